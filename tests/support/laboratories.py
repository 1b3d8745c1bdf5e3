"""Files of UFF-58 and TDMS with the channels of a run, by the packages that write them."""

import warnings

import nptdms
import numpy as np
import pyuff


def write_uff(path, signals, *rates, binary=False, function=1):
    """A universal file of signals {name: (n,)}, each at its rate or all at one."""
    path.unlink(missing_ok=True)
    rates = rates if len(rates) == len(signals) else rates * len(signals)
    for (name, values), rate in zip(signals.items(), rates, strict=True):
        told = {"func_type": function, "abscissa_spacing": 1, "abscissa_inc": 1.0 / rate, "ord_data_type": 4}
        axes = {"abscissa_spec_data_type": 17, "ordinate_spec_data_type": 8, "orddenom_spec_data_type": 0}
        place = {"rsp_node": 7, "rsp_dir": 1, "ref_node": 0, "ref_dir": 0}
        form = {"spec_data_type": 0, "byte_ordering": 1, "fp_format": 2, "n_ascii_lines": 11, "n_bytes": 8 * len(values)}
        heads = told | axes | place | (form if binary else {})
        data = pyuff.prepare_58(binary=int(binary), id1=name, data=values, x=np.arange(len(values)) / rate, **heads)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ResourceWarning)  # it leaves a file open while it writes
            pyuff.UFF(str(path)).write_sets(data, "add", force_double=binary)


def write_tdms(path, signals, *rates, groups="aaa", pieces=1):
    """A TDMS file of waveforms {name: (n,)}, each at its rate or all at one, each in its group."""
    rates = rates if len(rates) == len(signals) else rates * len(signals)
    channels = [
        [nptdms.ChannelObject(group, name, part, {"wf_increment": 1.0 / rate}) for part in np.array_split(values, pieces)]
        for group, (name, values), rate in zip(groups, signals.items(), rates, strict=True)
    ]
    with nptdms.TdmsWriter(str(path)) as writer:
        for parts in zip(*channels, strict=True):
            writer.write_segment(parts)
