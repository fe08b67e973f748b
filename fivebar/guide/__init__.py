"""Guide to fivebar: one page for each subject, with examples that run.

.. include:: models.md
.. include:: robot_files.md
.. include:: singularities.md
.. include:: simulation.md
.. include:: planning.md
.. include:: drawing.md
.. include:: measured_data.md
.. include:: design.md
.. include:: linkages.md
.. include:: compiled.md
.. include:: amoro.md
.. include:: charts.md
.. include:: security.md
.. include:: glossary.md
"""
