"""A law as a unit of FMI 2.0: a time headway. `pythonfmu build -f law.py` writes Law.fmu. See docs/tutorial.md."""

from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class Law(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.v = self.gap = self.dv = self.v_set = self.a = 0.0
        self.has_target = False
        self.headway = 2.0
        for name in ("v", "gap", "dv", "v_set"):
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        self.register_variable(Boolean("has_target", causality=Fmi2Causality.input))
        self.register_variable(Real("a", causality=Fmi2Causality.output))
        tunable = Fmi2Variability.tunable
        self.register_variable(Real("headway", causality=Fmi2Causality.parameter, variability=tunable))

    def do_step(self, time, step):
        request = 0.4 * (self.v_set - self.v)
        if self.has_target:
            request = min(request, 0.2 * (self.gap - 5.0 - self.headway * self.v) + 0.7 * self.dv)
        self.a = max(-4.0, min(2.0, request))
        return True
