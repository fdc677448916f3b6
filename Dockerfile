# The report from nothing, with the versions of the published one. The folder that it is called in gets the report and the
# store of finished runs, which the next call uses; its files belong to the caller:
#   docker build -t slip-to-roll .
#   docker run --rm --user "$(id -u):$(id -g)" --volume "$PWD:/desk" slip-to-roll report
FROM python:3.12-slim
# exudyn's modules are linked to OpenGL, though nothing is drawn with it.
RUN apt-get update && apt-get install -y --no-install-recommends libgl1 && rm -rf /var/lib/apt/lists/*
# The packages come before the source, which changes more often.
COPY docs/results/0.3.0/constraints.txt /versions.txt
RUN pip install --no-cache-dir -r /versions.txt
COPY . /slip-to-roll
RUN pip install --no-cache-dir -c /versions.txt "/slip-to-roll[taylor]"
# Whoever calls has no home here.
ENV HOME=/tmp
RUN mkdir --mode 1777 /desk
VOLUME /desk
WORKDIR /desk
ENTRYPOINT ["slip-to-roll"]
CMD ["--help"]
