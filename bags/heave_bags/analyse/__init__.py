"""Analysis: from a bag to signals, KPIs, tables and the report."""
