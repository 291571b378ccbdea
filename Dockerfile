# docker build -t mapless .
# docker run --rm --user "$(id -u):$(id -g)" -v "$PWD:/data" mapless detect recording -o out
FROM debian:12 AS build
COPY . /src
WORKDIR /src
RUN apt-get update && apt-get install -y --no-install-recommends make python3 && scripts/install_dependencies.sh package
RUN cmake --preset package && cmake --build --preset package && scripts/check_hardening.sh \
    build/package/apps/mapless/mapless compiled && cd build/package && cpack -G DEB && mv mapless_*.deb /mapless.deb

FROM debian:12-slim
COPY --from=build /mapless.deb /tmp/mapless.deb
RUN apt-get update && apt-get install -y --no-install-recommends /tmp/mapless.deb && \
    rm -rf /tmp/mapless.deb /var/lib/apt/lists/* && useradd --create-home mapless
USER mapless
WORKDIR /data
ENTRYPOINT ["mapless"]
