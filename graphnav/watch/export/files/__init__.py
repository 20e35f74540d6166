"""Write files atomically, and keep the first write error."""
