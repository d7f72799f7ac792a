"""What statics and linear theory say of a scenario, for people and machines: tables, numbers, pictures.

Each report has `table()` (text), `values()` (numbers with units in their names) and `draw(figure)`.
"""
