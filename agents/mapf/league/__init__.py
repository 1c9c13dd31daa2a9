"""The League of Robot Runners: its problems of 2023, 2024 and 2026, played by its rules."""
