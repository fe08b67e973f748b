def mechanism_functions():
    return []
