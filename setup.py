"""Package description; name, version and licence come from package.xml."""

from pathlib import Path
from xml.etree import ElementTree

from setuptools import find_packages, setup

HERE = Path(__file__).resolve().parent
manifest = ElementTree.parse(HERE / "package.xml").getroot()
NAME = manifest.findtext("name", "")
maintainer = manifest.find("maintainer")


def files(folder: str, pattern: str) -> list[str]:
    """Return the files of a folder, relative to this one, as setuptools requires."""
    return sorted(str(path.relative_to(HERE)) for path in (HERE / folder).glob(pattern))


# The wheels of ROS 2 exist for this platform only; elsewhere everything but the nodes works.
ROS_WHEELS = 'sys_platform == "linux" and platform_machine == "x86_64"'

setup(
    name=NAME,
    version=manifest.findtext("version"),
    description=" ".join(manifest.findtext("description", "").split()),
    long_description=(HERE / "README.md").read_text(encoding="utf-8"),
    long_description_content_type="text/markdown",
    maintainer=maintainer.text if maintainer is not None else None,
    maintainer_email=maintainer.get("email") if maintainer is not None else None,
    license=manifest.findtext("license"),
    # As of November 2026 the dependencies have wheels for Python 3.10 to 3.14, those of ROS 2 Jazzy (ros-rclpy 7.1.6) included: numba
    # 0.68.1, numpy 2.4 and 2.5, scipy 1.18.1, rerun-sdk 0.41.0 (abi3) and mcap 1.6.0. The exception is empy, which ROS 2 needs: pip builds
    # it from its source, in pure Python. The checks run on 3.10 to 3.13; no interpreter of 3.14 was available.
    python_requires=">=3.10,<3.15",
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={
        NAME: ["py.typed", "__init__.pyi"],
        f"{NAME}.plots": ["templates/*.html"],
        f"{NAME}.validation": ["assumptions.md"],
    },
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml", "QUALITY_DECLARATION.md"]),
        # Where `ros2 run` looks. Their names are too general for PATH.
        (f"lib/{NAME}", files("executables", "*")),
        (f"share/{NAME}/config", files("config", "*.yaml")),
        (f"share/{NAME}/config/scenarios", files("config/scenarios", "*.yaml")),
        (f"share/{NAME}/config/about", files("config/about", "*.yaml")),
        (f"share/{NAME}/config/exams", files("config/exams", "*.yaml")),
        (f"share/{NAME}/config/sweeps", files("config/sweeps", "*.yaml")),
        (f"share/{NAME}/config/vehicles", files("config/vehicles", "*.yaml")),
        (f"share/{NAME}/launch", files("launch", "*.py")),
        (f"share/{NAME}/examples", files("examples", "*.py")),
        (f"share/{NAME}/examples/detectors", files("examples/detectors", "*.*")),
        (f"share/{NAME}/examples/ros", files("examples/ros", "*")),
        (f"share/{NAME}/foxglove", files("foxglove", "*.json")),
        *((f"share/{NAME}/bags/{bag.name}", files(f"bags/{bag.name}", "*")) for bag in sorted((HERE / "bags").iterdir()) if bag.is_dir()),
    ],
    zip_safe=False,
    install_requires=[
        "numpy>=1.26,<3",
        "numba>=0.60,<1",
        "scipy>=1.11,<2",
        "platformdirs>=4,<5",
        "pydantic>=2.7,<3",
        "pyyaml>=6,<7",
        "typer>=0.12,<1",
        "rich>=13,<16",
        "matplotlib>=3.8,<4",
        "jinja2>=3.1,<4",
        "mcap>=1.6,<2",
        "pillow>=10,<14",
        "rosbags>=0.10.10,<0.12",
        "rerun-sdk>=0.39,<0.42",
        "pyarrow>=14",
        "junitparser>=3,<6",
    ],
    extras_require={
        "ros": [
            f"ros-jazzy-rclpy[fastrtps]>=7.1,<8; {ROS_WHEELS}",
            f"ros-jazzy-common-interfaces>=5.3,<6; {ROS_WHEELS}",
        ],
        "test": [
            "pytest>=8,<10",
            "pytest-timeout>=2.3,<3",
            "pytest-xdist>=3.5,<4",
            "hypothesis>=6.100,<7",
            "mcap-ros2-support>=0.5,<1",
            "import-linter>=2.1,<3",
            "ruff>=0.17,<0.18",
            # Types are checked against one generation of stubs, or every release of numpy brings other errors.
            "mypy>=2.4,<2.5",
            'numpy>=2.4,<2.5; python_version >= "3.11"',
            'scipy-stubs>=1.17,<1.18; python_version >= "3.11"',
            "types-PyYAML>=6.0.12,<7",
            # The classifiers of the tutorials.
            "scikit-learn>=1.4,<2",
            # The recipe for MQTT: the client of the example, and a broker where mosquitto is not installed.
            "paho-mqtt>=2,<3",
            "amqtt>=0.12,<0.13",
            # The tests read the notebooks.
            "nbformat>=5.10,<6",
        ],
        "mat73": ["h5py>=3.8,<4"],
        # Dask is for the workers of a cluster; a sweep on one machine does not need it.
        "sweep": ["dask>=2024.2", "distributed>=2024.2", "fsspec>=2024.2", "pandas>=2.2,<4"],
        "docs": [
            "mkdocs>=1.6,<2",
            "mkdocs-material>=9.5,<10",
            "mkdocs-jupyter>=0.25,<1",
            "ipykernel>=6.29,<8",
            "mkdocstrings[python]>=1.0,<2",
        ],
        "colcon": ["colcon-common-extensions>=0.3,<1", "setuptools>=68,<80"],
    },
    entry_points={
        "console_scripts": [
            "dcrb = dcrb_ros.cli.program:main",
            "dcrb_simulator = dcrb_ros.nodes.programs:simulator",
            "dcrb_vehicle_simulator = dcrb_ros.nodes.programs:vehicle_simulator",
            "dcrb_replayer = dcrb_ros.nodes.programs:replayer",
            "dcrb_fault_detector = dcrb_ros.nodes.programs:fault_detector",
            "dcrb_vehicle_detector = dcrb_ros.nodes.programs:vehicle_detector",
            "dcrb_hot_box_detector = dcrb_ros.nodes.programs:hot_box_detector",
            "dcrb_viewer = dcrb_ros.nodes.programs:viewer",
        ],
    },
)
