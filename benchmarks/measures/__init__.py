"""What ``micro.py`` measures, a module for each part."""
