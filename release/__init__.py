"""What is handed out: source distribution, wheel with the libraries inside, ready FMUs, checksums, bill of materials.

    libraries   the compiled code that the wheel brings
    wheels      source distribution and wheel
    bill        what is in them and what they need (CycloneDX)
    __main__    all of it in one folder, with checksums
    trial       the wheel in a fresh environment without a compiler

Not a part of the product, and not installed.
"""
