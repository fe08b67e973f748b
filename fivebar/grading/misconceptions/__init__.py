"""The labs' models step by step, the same for cranks and sliders, and the slips in the steps."""
