"""The folder `models/`: found from a checkout, an editable install and an installed wheel alike."""

from collections.abc import Callable
from pathlib import Path
from typing import Protocol, TypeVar

import yaml
from pydrake.common.yaml import yaml_load_typed
from pydrake.multibody.parsing import Parser

from fikm_drake.yaml_errors import explain

_PACKAGE = Path(__file__).resolve().parent

Schema = TypeVar("Schema")
Prepare = Callable[[yaml.MappingNode], None]


class _Model(Protocol):
    def validate(self) -> None: ...


Model = TypeVar("Model", bound=_Model)


def models_dir() -> Path:
    """The folder of arms, URDFs and scenarios.

    Raises:
        FileNotFoundError: the installation is damaged.
    """
    for folder in (_PACKAGE / "models", _PACKAGE.parent / "models"):  # a wheel; a checkout
        if (folder / "package.xml").is_file():
            return folder
    raise FileNotFoundError(f"no models folder beside or in {_PACKAGE}: reinstall fikm_drake")


def model_names(folder: str = "") -> list[str]:
    """Names of the YAML files in `models/` or in a folder of it, sorted."""
    return sorted(path.stem for path in (models_dir() / folder).glob("*.yaml"))


def find_model(name_or_path: str | Path, *, folder: str = "", kind: str = "arm") -> Path:
    """Path of a YAML file: of one of our models by its name, or of the user's own by its path.

    Args:
        name_or_path: a name such as `arm7`, or a path that ends in .yaml or .yml.
        folder: where in `models/` to look for the name.
        kind: what the error calls it.

    Raises:
        FileNotFoundError: there is none; the message lists the names there are.
    """
    path = Path(name_or_path)
    if path.suffix in (".yaml", ".yml"):
        if path.is_file():
            return path
        raise FileNotFoundError(f"no {kind} file {path}")
    if path.name == str(name_or_path):
        ours = models_dir() / folder / f"{path.name}.yaml"
        if ours.is_file():
            return ours
    names = ", ".join(model_names(folder))
    raise FileNotFoundError(
        f"no {kind} {str(name_or_path)!r}; give the path of a .yaml file or one of: {names}"
    )


def load_yaml(
    schema: type[Schema], path: Path, *, kind: str, prepare: Prepare | None = None
) -> Schema:
    """Read a YAML file into a dataclass by Drake's typed YAML.

    Args:
        schema: the dataclass.
        path: of the file.
        kind: what the error calls it.
        prepare: may change the file's tree before it is read into the dataclass, or raise ValueError.

    Raises:
        ValueError: the file is not YAML, has a key twice, or does not fit the dataclass; the message
            names the file.
    """
    tree: yaml.Node | None = None
    try:
        text = path.read_text("utf-8")
        tree = yaml.compose(text, Loader=yaml.SafeLoader)
        if tree is None:
            raise ValueError("it is empty")
        _check_keys(tree)
        if prepare is not None and isinstance(tree, yaml.MappingNode):
            prepare(tree)
            text = yaml.serialize(tree)
        return yaml_load_typed(schema=schema, data=text, retain_map_defaults=True)
    except OSError:
        raise
    except Exception as error:  # Drake and PyYAML raise many kinds
        reason = explain(error, schema, tree)
        raise ValueError(f"{path} is not a valid {kind} file: {reason}") from error


def _check_keys(node: yaml.Node | None) -> None:
    """Raise ValueError for a key that stands twice in a mapping: YAML's readers take the last one."""
    if isinstance(node, yaml.SequenceNode):
        for item in node.value:
            _check_keys(item)
    elif isinstance(node, yaml.MappingNode):
        lines: dict[object, int] = {}
        for key, value in node.value:
            line = key.start_mark.line + 1
            if isinstance(key, yaml.ScalarNode):
                if key.value in lines:
                    raise ValueError(
                        f"key {key.value!r} stands twice, in lines {lines[key.value]} and {line}"
                    )
                lines[key.value] = line
            _check_keys(value)


def load_model(
    schema: type[Model],
    name_or_path: str | Path,
    *,
    folder: str = "",
    kind: str,
    prepare: Prepare | None = None,
) -> Model:
    """Read one of our models, or a user's file, into a dataclass and validate it.

    Args:
        schema: the dataclass; it has a method `validate` that raises ValueError.
        name_or_path: as of `find_model`.
        folder: where in `models/` to look for the name.
        kind: what the error calls it.
        prepare: as of `load_yaml`.

    Raises:
        FileNotFoundError: there is no such file; the message lists the names there are.
        ValueError: the file does not describe such a model; the message names the file.
    """
    path = find_model(name_or_path, folder=folder, kind=kind)
    model = load_yaml(schema, path, kind=kind, prepare=prepare)
    try:
        model.validate()
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    return model


def ConfigureParser(parser: Parser) -> None:
    """Let `parser` resolve `package://fikm_drake/…`, like Drake's manipulation.ConfigureParser."""
    parser.package_map().AddPackageXml(str(models_dir() / "package.xml"))
