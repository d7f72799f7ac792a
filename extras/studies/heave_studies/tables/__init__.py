"""Tables of cases as files: written, and a case of one taken out again to be run."""
