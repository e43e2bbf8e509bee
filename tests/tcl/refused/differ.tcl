loadrt stepgen step_type=2
