"""The command ``reference``: the documents' own programs on recorded counts."""
