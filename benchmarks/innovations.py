class Innovations:
    is_wanted=False
    def __init__(self, drone): pass
