"""What one student's checks came to: as text, page, JSON, CSV."""
