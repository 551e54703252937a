"""The true world: the only place that imports libsumo."""
