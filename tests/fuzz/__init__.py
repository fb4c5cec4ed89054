"""Files as nobody would write them: does every loader name what is wrong, and nothing else?"""
