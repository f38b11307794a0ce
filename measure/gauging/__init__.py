"""The gauges, read off a curve through the points, each with what moves it."""
