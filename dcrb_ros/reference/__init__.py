"""The paper's own formulation, the yardstick of the fast solver: readable before fast, numpy and scipy only.

Every body keeps its three coordinates; joints are constraints with Lagrange multipliers and Baumgarte's stabilisation
(Eqs. 31 to 37 of Fan et al. 2025), integrated by the classical Runge-Kutta method (Eqs. 39 and 40).
"""
