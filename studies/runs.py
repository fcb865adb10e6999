"""What the studies share: runs of isph, each made once and kept in a CSV file, one row a run."""
import csv
import os
import subprocess
import tempfile

FORMS = ["morris", "gotoh", "schwaiger", "corrected", "direct_scalar", "fatehi_manzari", "lsph", "mls",
         "mls3"]
COLOURS = dict(zip(FORMS, ["#000000", "#E69F00", "#56B4E9", "#009E73", "#999999", "#CC79A7", "#8C6D31",
                           "#0072B2", "#D55E00"]))  # told apart by every eye
MARKERS = dict(zip(FORMS, "osd^xPvD*"))


class Runs:
    """Quantities of runs by their arguments; a run that failed has the sentence in `failed`."""

    def __init__(self, path, isph):
        self.path, self.isph, self.rows, self.unsaved = path, isph, {}, 0
        os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
        if os.path.exists(path):
            with open(path, newline="") as file:
                for row in csv.DictReader(file):
                    self.rows[row["run"]] = {k: v for k, v in row.items() if v}

    def __call__(self, arguments):
        """The quantities of a run as numbers; it is made unless the file has it."""
        if arguments not in self.rows:
            print(arguments, flush=True)
            self.rows[arguments] = self.make(arguments)
            self.unsaved += 1
            if self.unsaved >= 20:
                self.save()
        return {k: float(v) if k not in ("run", "failed") else v
                for k, v in self.rows[arguments].items()}

    def make(self, arguments):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "run.csv")
            done = subprocess.run([self.isph, *arguments.split(), "-report", path],
                                  capture_output=True, text=True, check=False)
            row = {"run": arguments}
            if done.returncode:
                sentence = [line for line in done.stderr.splitlines() if line.startswith("isph: ")]
                row["failed"] = sentence[0][6:] if sentence else f"status {done.returncode}"
                return row
            with open(path, newline="") as file:
                lines = list(csv.DictReader(file))
            for line in lines:  # of -report_times quantity@t, at the end of the run quantity
                time = "" if line["t"] == lines[-1]["t"] else f"@{float(line['t']):.4g}"
                row[line["quantity"] + time] = line["value"]
                row["wall_s"], row["particles"] = line["wall_s"], line["particles"]
            return row

    def save(self):
        names = ["run", "failed"]
        for row in self.rows.values():
            names += [name for name in row if name not in names]
        with open(self.path + ".new", "w", newline="") as file:
            writer = csv.DictWriter(file, names, lineterminator="\n")
            writer.writeheader()
            writer.writerows(self.rows.values())
        os.replace(self.path + ".new", self.path)
        self.unsaved = 0


def table(head, rows):
    """Lines of a Markdown table."""
    yield "| " + " | ".join(head) + " |"
    yield "|" + " --- |" * len(head)
    for row in rows:
        yield "| " + " | ".join(str(cell) for cell in row) + " |"


def write(path, lines):
    with open(path, "w") as file:
        file.writelines(line + "\n" for line in lines)
