import interpreter


def twice(self, value):
    return 2.0 * value


def nothing(self, *values):
    self.params["_sum"] = sum(values)


def yields(self):
    yield interpreter.INTERP_EXECUTE_FINISH
    self.execute("G0 X5")
    yield 7.5


def status(self):
    return interpreter.INTERP_ERROR


def itself(self):
    self.execute("o<itself> call")
