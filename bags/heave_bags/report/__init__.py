"""The report: what a run came to, for people: few figures, one page, its pictures, on paper too."""
