"""Whether a run errs by no more than was asked: accuracy.end_force and accuracy.loop on seeded scenes, docs/promise.md.

scenes     ropes, swivels, trips and communication steps from a seed
wind       a scene asked for an accuracy, and its errors against a much finer run
judge      shares and distributions of a table of scenes
page       what the page promise.md.j2 says; figures
"""
