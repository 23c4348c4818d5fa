# Two images: `--target server` hosts episodes, `--target agent` plays them and holds no simulator.
# Any base with apt and Python 3.11 to 3.14, venv included, will do. Behind a network that encrypts with a CA of its own, hand
# that in as a secret, `--secret id=ca,src=FILE`: it is trusted while packages are fetched, and is in no layer.
ARG BASE=docker.io/library/python:3.11-slim

FROM ${BASE} AS builder
ENV PIP_NO_CACHE_DIR=1 PIP_DISABLE_PIP_VERSION_CHECK=1
COPY deploy/trusting /usr/local/bin/trusting
RUN python3 -m venv /opt/arramon
WORKDIR /build
COPY LICENSE ./
COPY proto proto
COPY clients clients
RUN --mount=type=secret,id=ca trusting /opt/arramon/bin/pip install ./clients/python

FROM builder AS server-builder
COPY pyproject.toml README.md ./
COPY src src
COPY server server
COPY dataset dataset
COPY collecting collecting
COPY packages packages
COPY agents agents
COPY lang lang
# pybullet carries 150 MB of models and gyms that nothing here reads, and 125 MB of symbols. With a newer Python than 3.11, or
# another processor than x86-64, it has no build and is not there: plane geometry decides alike.
RUN --mount=type=secret,id=ca \
    trusting apt-get update -qq && trusting apt-get install -y -qq --no-install-recommends binutils > /dev/null
RUN --mount=type=secret,id=ca trusting /opt/arramon/bin/pip install ./packages/lang ./packages/agents . \
    && find /opt/arramon -name 'pybullet.*.so' -exec strip --strip-unneeded {} + \
    && rm -rf /opt/arramon/lib/python3*/site-packages/pybullet_data \
              /opt/arramon/lib/python3*/site-packages/pybullet_envs \
    && find /opt/arramon -name tests -type d -path '*/site-packages/*' -prune -exec rm -rf {} +

FROM builder AS agent-builder
# The project's own agents. The index has torch for the CPU; another brings it for GPUs. Empty, it
# is the index that pip is configured with.
ARG TORCH=torch==2.13.0
ARG TORCH_INDEX=https://download.pytorch.org/whl/cpu
RUN --mount=type=secret,id=ca trusting /opt/arramon/bin/pip install ${TORCH_INDEX:+--index-url "$TORCH_INDEX"} "$TORCH"
COPY packages packages
COPY agents agents
COPY lang lang
RUN --mount=type=secret,id=ca trusting /opt/arramon/bin/pip install ./packages/lang './packages/agents[torch]'

FROM ${BASE} AS runtime
ENV PATH=/opt/arramon/bin:$PATH PYTHONUNBUFFERED=1 PYTHONDONTWRITEBYTECODE=1
RUN useradd --uid 10001 --user-group --no-create-home --shell /usr/sbin/nologin arramon \
    && install -d -o arramon -g arramon /data

FROM runtime AS agent
COPY --from=agent-builder /opt/arramon /opt/arramon
# A volume that is mounted here for the first time takes its owner from this folder.
RUN install -d -o arramon -g arramon /data/results
USER 10001
# Without --output, results go into /data/arramon-results.
WORKDIR /data
# For what the visual encoder compiles, in containers that may write nowhere else.
ENV NUMBA_CACHE_DIR=/tmp/compiled
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
