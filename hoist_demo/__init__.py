"""Host of the balance rope: a friction hoist in CasADi, co-simulated with the rope.

Packages; tests/project/layers.toml lists what each may import:

    parameters       data of hoist, trip and coupling, checked
    drive | control  the hoist as a model | the reference and the controller that follows it
    recording        signals of a run over time
    files            TOML files: values with units, reading, all parameters by name, a rope's file
    cases            a hoist as a whole, by name or from its file; what follows by rules
    drive_fmu        drive and control of a case as C, for an FMU
    cosimulation     participants (hoist, ropes), the schemes that couple them, the host's loop
    design           trips shaped and optimised on a reduced model
    run              one run: data with their sources, ropes, winding, slip, metrics
    study | duty     many runs over chosen parameters | many trips as one run
    report           a run as text, figures and Markdown; report.html as pages
    calibration      a rope's properties from measurements
    uncertainty      windings over all that is not known of a rope
    export           a hoist's drive and ropes as FMUs and as one system; it knows fmu_src, too
    command_line     the commands

Signs. Heights and vertical forces are positive upwards; a positive travel, sheave angle and torque
lift the left conveyance. Forces of the balance rope are those on the conveyance, so that a hanging
rope has ``fy`` < 0. SI units.
"""

from importlib.metadata import version

__version__ = version("balance-rope")
