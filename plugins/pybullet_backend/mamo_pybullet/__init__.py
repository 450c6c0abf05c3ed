"""The PyBullet backend."""
