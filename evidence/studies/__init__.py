"""The worked studies: tables, figures and sentences of docs/study_controllers.md and docs/study_swivel.md."""
