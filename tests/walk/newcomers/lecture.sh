# A lecture with a curve of its own: a film, a figure and a map.
slip-to-roll cases new half_pipe
sed -i 's/lambda s: (.*), domain/lambda s: (s, 0.6*s**2 - 0.1*s**3), domain/' half_pipe.py
slip-to-roll cases check half_pipe.py  # first result
slip-to-roll cases show half_pipe.py mu=0.3 --out half_pipe.pdf
slip-to-roll animate half_pipe.py --out half_pipe.gif
slip-to-roll sweep half_pipe.py --vary mu=0.02:0.5:40 --vary xi1=-1:-0.1:40
