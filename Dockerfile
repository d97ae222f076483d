# ROS 2 Jazzy with crazychoir_fw: docker build --tag crazychoir . && docker run --rm -it crazychoir
FROM ros:jazzy-ros-base

RUN apt-get update \
    && apt-get install --yes --no-install-recommends \
        build-essential python3-dev python3-venv libegl1 libopengl0 libgl1-mesa-dri \
    && rm -rf /var/lib/apt/lists/*

WORKDIR /opt/crazychoir
COPY . .

# rclpy is that of ROS 2, seen through the system's packages
RUN python3 -m venv --system-site-packages /opt/venv \
    && /opt/venv/bin/pip install --no-cache-dir '.[radio,optimization,gui,mcap]' honcho rosbags

ENV PATH=/opt/venv/bin:$PATH \
    AMENT_PREFIX_PATH=/opt/venv:/opt/ros/jazzy

CMD ["crazychoir", "fly", "examples/bearing_formation.yaml", "--ros"]
