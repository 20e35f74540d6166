"""How ``tools/train_policy.py`` drives, learns and exports."""
