"""The coupling schemes of drive and rope on the hoist: orders, errors and costs, and the default on every case."""
