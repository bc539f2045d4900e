# GaitSLAM from a bare Debian 12:
#     docker build -t gaitslam .
#     docker run --rm -v "$PWD/results:/data/results" gaitslam run /usr/share/gaitslam/scenarios/tangent_circle.yaml
FROM debian:12 AS build
WORKDIR /source
COPY tools/packages.txt tools/
RUN apt-get update \
 && sed 's/#.*//' tools/packages.txt | xargs apt-get install -y --no-install-recommends git dpkg-dev file \
 && rm -rf /var/lib/apt/lists/*
COPY . .
RUN cmake --preset release -DGAITSLAM_TESTS=OFF -DCMAKE_INSTALL_PREFIX=/usr \
 && cmake --build build/release \
 && cd build/release && cpack -G DEB

FROM debian:12
COPY --from=build /source/build/release/gaitslam_*.deb /tmp/
RUN apt-get update \
 && apt-get install -y --no-install-recommends /tmp/gaitslam_*.deb \
 && rm -rf /var/lib/apt/lists/* /tmp/gaitslam_*.deb
WORKDIR /data
ENTRYPOINT ["gaitslam"]
CMD ["--help"]
