"""Former names of configuration fields, which files, options and session folders of earlier versions contain."""

from __future__ import annotations

from collections.abc import Mapping

UNTIL = "0.3"
"""First version that no longer accepts the former names."""

RENAMED = {
    "group": "dancers",
    "room.move_m": "dance.step_m",
    "room": "scene",
    "stage.balance_hz": "physics.control_hz",
    "stage.truth_hz": "physics.ground_truth_hz",
    "stage": "physics",
    "body.tether": "body.balance_support",
    "body.tether_force_n": "body.support_force_n",
    "body.tether_torque_nm": "body.support_torque_nm",
    "sensors.idle_hz": "sensors.standby_hz",
    "sensors.bias_m": "joint_noise.bias_m",
    "sensors.drift_m": "joint_noise.drift_m",
    "sensors.drift_correlation": "joint_noise.drift_correlation",
    "sensors.limb_drift_m": "joint_noise.limb_drift_m",
    "sensors.limb_drift_correlation": "joint_noise.limb_drift_correlation",
    "sensors.hidden_factor": "joint_noise.occluded_factor",
    "sensors.hidden_factor_hand": "joint_noise.occluded_factor_hand",
    "detectors.on_m_s": "detectors.start_speed_m_s",
    "detectors.off_m_s": "detectors.stop_speed_m_s",
    "detectors.early_rest_s": "detectors.early_refractory_s",
    "detectors.clap_rest_s": "detectors.clap_refractory_s",
    "detectors.assist_s": "detectors.side_clap_window_s",
    "detectors.early_step_m": "detectors.early_displacement_m",
    "robot.track_m": "robot.wheel_separation_m",
    "robot.track_error": "robot.wheel_separation_error",
    "robot.command_timeout_s": "robot.cmd_timeout_s",
    "robot.dead_time_s": "robot.command_latency_s",
    "network.loss": "network.packet_loss",
    "network.uplink_extra_s": "network.uplink_asymmetry_s",
    "clocks.offset_s": "clocks.max_offset_s",
    "clocks.drift": "clocks.max_skew",
}
"""Former dotted name -> present name. The entry of a table applies to its fields that have no entry of their own."""

RENAMED_SIA_OPTIONS = {
    "method_options.tau_s": "synchrony.tau_s",
    "method_options.effective_from": "method_options.first_followed_iteration",
}
"""Former dotted name -> present name, for the options of the method ``sia``."""


def present_name(name: str) -> str:
    """Return the present dotted name of a configuration field; a name that has not changed is returned unchanged."""
    if name in RENAMED:
        return RENAMED[name]

    table, dot, field = name.partition(".")
    return f"{RENAMED[table]}.{field}" if dot and table in RENAMED else name


def with_present_names(data: Mapping[str, object]) -> tuple[dict[str, object], dict[str, str]]:
    """Replace former field names in plain configuration data.

    Args:
        data: fields of `SessionConfig`, with tables as nested mappings. If a field is given under both names, the value
            of the present name is used.

    Returns:
        the data with present names, and a mapping former name -> present name of the fields that were renamed.
    """
    out: dict[str, object] = {}
    renamed: dict[str, str] = {}
    for name, value in _flat(data):
        present = present_name(name)
        # Other methods may have options with the same names, so these renames apply to SIA only.
        if data.get("method", "sia") == "sia":
            present = RENAMED_SIA_OPTIONS.get(name, present)
        if present != name:
            renamed[name] = present
        _put(out, present, value, replace=present == name)
    return out, renamed


def renamed_message(former: str, present: str) -> str:
    """Return the warning for a former field name."""
    return f"{former} is now called {present}; the former name is accepted until sjasim {UNTIL}"


def _flat(data: Mapping[str, object]) -> list[tuple[str, object]]:
    """Return (dotted name, value) of every field, including the fields of tables; an empty table is kept as a value."""
    rows: list[tuple[str, object]] = []
    for key, value in data.items():
        if isinstance(value, Mapping) and value:
            rows += [(f"{key}.{field}", item) for field, item in value.items()]
        else:
            rows.append((str(key), value))
    return rows


def _put(out: dict[str, object], name: str, value: object, *, replace: bool) -> None:
    """Set the value of a dotted name in ``out``; an existing value is kept unless ``replace`` is True."""
    table, dot, field = name.partition(".")
    if not dot:
        out[name] = value if replace else out.get(name, value)
        return

    fields = out.setdefault(table, {})
    if isinstance(fields, dict):
        fields[field] = value if replace else fields.get(field, value)
