import interpreter
from emccanon import MESSAGE


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


def refused(self):
    self.params[5400] = 3.0
    self.execute("G0 X1")


def refused_inside(self):
    self.execute("o<refused> call")


def stubborn(self):
    try:
        self.params[5400] = 3.0
        self.execute("G0 X1")
    except BaseException:
        self.execute("G0 X2")


def slow(self):
    while True:
        pass


def caught(self, n):
    name = ["refused", "refused_inside", "stubborn", "slow"][int(n)]
    try:
        self.execute("o<%s> call" % name)
    except interpreter.InterpreterException as error:
        MESSAGE(error.error_message)
    return n + 0.5
