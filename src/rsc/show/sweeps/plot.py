"""`rsc.plot_sweep`: a picture of the dataset of a sweep on axes of matplotlib."""

from typing import TYPE_CHECKING, Any

from rsc.arguments import AXES, DATASET, TEXT, optional, takes
from rsc.errors import SceneError, one_line
from rsc.results.labelled import of_xarray
from rsc.show.pictures.of_results import own_axes
from rsc.show.sweeps.pictures import NOTHING, drawings, panels_apart, refuse_undrawable, scene_of
from rsc.show.words.units import shown_as_in

if TYPE_CHECKING:
    import xarray


@takes(data=DATASET, picture=optional(TEXT), ax=optional(AXES))
def plot_sweep(data: "xarray.Dataset", picture: str | None = None, ax: Any = None) -> Any:
    """Draw one picture of a sweep, as `rsc plot` draws all of them.

    Parameters
    ----------
    data : xarray.Dataset
        Of `rsc.sweep`, of `xarray.open_dataset` and a file that `rsc sweep` wrote, or a part of it (`data.sel(...)`).
    picture : str, optional
        Over two varied keys the name of a map ("danger", "motion", "force", ...), over one that of a quantity
        ("whirl_frequency", "amplitude", "normal_force", ...); by default the first that the sweep has. An error lists them.
    ax : matplotlib axes, by default those of a new figure

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    SceneError
        A picture that the sweep does not have, or something that is no dataset of a sweep.
    DataError
        A number is so large that no axis can carry it.

    Examples
    --------
    >>> found = rsc.sweep(rsc.load_scene("laval.toml"), {"contact.friction": "0.1:0.3:9"})
    >>> axes = rsc.plot_sweep(found)
    """
    arrays = of_xarray(data)
    refuse_undrawable(arrays)
    with shown_as_in(scene_of(arrays)):
        drawn = panels_apart(drawings(arrays))
        if not drawn:
            raise SceneError("plot_sweep", "data", one_line(arrays.attributes.get("title", "")), f"one with {NOTHING}")
        picture = next(iter(drawn)) if picture is None else picture
        if picture not in drawn:
            raise SceneError("plot_sweep", "picture", picture, f"one of {', '.join(drawn)}")
        ax = own_axes(ax)
        drawn[picture](axes=ax)
    return ax
