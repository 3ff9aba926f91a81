"""The reference solver: the paper's own formulation, with which the production solver is compared.

It is written for readability with numpy and scipy, and shares no contact or friction code with the kernels. Every body keeps its
three coordinates; joints are constraints with Lagrange multipliers and Baumgarte stabilisation (Eqs. 31 to 37 of Fan et al. 2025),
integrated by the classical Runge-Kutta method (Eqs. 39 and 40).
"""
