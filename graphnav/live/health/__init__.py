"""The health of a live run: status, alarms, and a watchdog for steps that hang."""
