"""What is drawn, and with what: figures, scenes, linked pages."""
