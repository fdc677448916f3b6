"""A case and its parts: plate, start, supports, further plates; what is rejected, and cases of one contact."""
