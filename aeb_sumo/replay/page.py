def page(take): return ""
