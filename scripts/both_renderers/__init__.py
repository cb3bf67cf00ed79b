"""One scene rendered by Tamis and by Mitsuba 3, for the scripts beside this folder.

For Mitsuba, geometry and materials are read anew from OBJ and MTL files, as Tamis documents them; no code is shared with
Tamis. Needs mitsuba, numpy, openexr and pillow.

What Mitsuba has no equal of is built here, from its documented formula:

* `coat`, a diffuse base under a GGX coat.
* `compensated`, Mitsuba's own `roughconductor` or `roughdielectric` times the light that facets scatter more than once,
  which Tamis gives back and Mitsuba does not.
* The smooth edge of a spot, whose falloff is linear in the angle in Mitsuba: a picture before a spot with a hard edge
  (`lights`).
* A sun of some size: a disk so far away that nothing in the scene sees it elsewhere (`lights`).

Read are textures of the diffuse colour and of opacity; others are an error.
"""
