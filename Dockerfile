# The report from nothing, with the versions of the published one:
#   docker build -t slip-to-roll .
#   docker run --rm -v "$PWD/out:/out" slip-to-roll report --out /out/report
FROM python:3.12-slim
# exudyn's modules are linked to OpenGL, though nothing is drawn with it.
RUN apt-get update && apt-get install -y --no-install-recommends libgl1 && rm -rf /var/lib/apt/lists/*
COPY . /slip-to-roll
RUN pip install --no-cache-dir -c /slip-to-roll/docs/results/0.2.0/constraints.txt "/slip-to-roll[taylor]"
WORKDIR /desk
ENTRYPOINT ["slip-to-roll"]
CMD ["--help"]
