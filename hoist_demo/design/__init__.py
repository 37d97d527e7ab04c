"""Design of a trip on the lowest model that serves, to be verified on the complete rope by co-simulation.

shaping, low_fidelity -> optimal_trajectory -> controllers (chosen by name); linear_model -> linearise -> reduction;
swing measures what is left after arrival; tuning searches over complete runs.
"""
