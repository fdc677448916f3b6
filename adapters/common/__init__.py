"""What several engines need: the reader of half-step velocities, curves as corners, plates that leave their track."""
