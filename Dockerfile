# The bench on Ubuntu 24.04 with ROS 2 Jazzy from its own packages:
#   docker build -t dcrb_ros . && docker run --rm -it --network host --ipc host dcrb_ros ros2 launch dcrb_ros bench.launch.py
FROM ros:jazzy-ros-base

WORKDIR /workspace
COPY package.xml src/dcrb_ros/package.xml
RUN apt-get update \
    && apt-get install --no-install-recommends --yes python3-pip \
    && rosdep update --rosdistro jazzy \
    && rosdep install --from-paths src --ignore-src --yes \
    && rm -rf /var/lib/apt/lists/*
# Ubuntu packages no recent enough version of these, or none.
RUN python3 -m pip install --no-cache-dir --break-system-packages --ignore-installed \
    "numba>=0.60" "pydantic>=2.7" "platformdirs>=4" "typer>=0.12" "rich>=13" "mcap>=1.6" "rosbags>=0.10.10" "rerun-sdk>=0.39" "junitparser>=3" \
    "scipy>=1.13" "matplotlib>=3.9" "jinja2>=3.1" "pyarrow>=14" "dask>=2024.2" "distributed>=2024.2" "fsspec>=2024.2" "pandas>=2.2"

COPY . src/dcrb_ros
RUN . /opt/ros/jazzy/setup.sh && colcon build
RUN echo '. /workspace/install/setup.bash' >> /etc/bash.bashrc \
    && sed --in-place 's|^exec |. /workspace/install/setup.bash\nexec |' /ros_entrypoint.sh
# Nothing runs as root. The kernels are cached below the home folder, and recordings are written to it by default.
RUN useradd --create-home --shell /bin/bash dcrb
USER dcrb
WORKDIR /home/dcrb
CMD ["ros2", "launch", "dcrb_ros", "bench.launch.py"]
