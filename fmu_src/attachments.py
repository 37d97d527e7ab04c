"""placeholder"""


def attachments(table, preset, level, fmi, native):
    return {}
