# The report from nothing: docker build -t slip-to-roll . && docker run -v "$PWD/out:/out" slip-to-roll report --out /out/report
FROM python:3.12-slim
COPY . /slip-to-roll
RUN pip install --no-cache-dir -c /slip-to-roll/constraints.txt "/slip-to-roll[taylor]"
WORKDIR /desk
ENTRYPOINT ["slip-to-roll"]
CMD ["--help"]
