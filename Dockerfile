# Two images: `--target server` hosts episodes, `--target agent` plays them and holds no simulator.
# Any base with apt and Python 3.11 or later, venv included, will do.
ARG BASE=docker.io/library/python:3.11-slim

FROM ${BASE} AS builder
ENV PIP_NO_CACHE_DIR=1 PIP_DISABLE_PIP_VERSION_CHECK=1
RUN python3 -m venv /opt/arramon
WORKDIR /build
COPY proto proto
COPY clients clients
RUN /opt/arramon/bin/pip install ./proto ./clients/python

FROM builder AS server-builder
COPY pyproject.toml README.md LICENSE ./
COPY server server
COPY agents agents
COPY lang lang
# pybullet carries 150 MB of models and gyms that nothing here reads, and 125 MB of symbols.
RUN apt-get update -qq && apt-get install -y -qq --no-install-recommends binutils > /dev/null
RUN /opt/arramon/bin/pip install . \
    && strip --strip-unneeded /opt/arramon/lib/python3*/site-packages/pybullet.*.so \
    && rm -rf /opt/arramon/lib/python3*/site-packages/pybullet_data \
              /opt/arramon/lib/python3*/site-packages/pybullet_envs \
    && find /opt/arramon -name tests -type d -path '*/site-packages/*' -prune -exec rm -rf {} +

FROM builder AS agent-builder
# What the project's own agents need beside the client.
RUN /opt/arramon/bin/pip install scipy
COPY agents agents
COPY lang lang
RUN cp -r agents lang /opt/arramon/lib/python3*/site-packages/

FROM ${BASE} AS runtime
ENV PATH=/opt/arramon/bin:$PATH PYTHONUNBUFFERED=1 PYTHONDONTWRITEBYTECODE=1
RUN useradd --uid 10001 --user-group --no-create-home --shell /usr/sbin/nologin arramon \
    && mkdir /data && chown arramon:arramon /data

FROM runtime AS agent
COPY --from=agent-builder /opt/arramon /opt/arramon
USER 10001
# Results go where /data is mounted.
WORKDIR /data
ENTRYPOINT ["arramon-client"]
CMD ["--help"]

FROM runtime AS server
COPY --from=server-builder /opt/arramon /opt/arramon
COPY examples/sample /usr/share/arramon/sample
# In /data: episodes, journal, and the camera's code, compiled for the processor that runs it: all that is ever written.
ENV ARRAMON_DATA=/data NUMBA_CACHE_DIR=/data/compiled
USER 10001
EXPOSE 50551
ENTRYPOINT ["arramon-server"]
CMD ["serve", "--listen", "0.0.0.0:50551"]
