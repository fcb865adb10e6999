"""The options of isph, as its reference page lists them."""
import os
import re
import subprocess

from random_input.runs import environment


class Option:
    """A row of the reference page."""

    def __init__(self, cells, places):
        self.name, self.kind, _, _, self.allowed, self.where, _ = cells
        self.places = places

    def named(self, rng):
        """Returns the name with words in the places of <word>."""
        number = rng.choice(("1", "1", "1", "1", "2", "3", "16", "17", "0", "99999999999999999999"))
        name = self.name.replace("<k>", number)
        quantity = rng.choice(("kinetic_energy", "u_min", "velocity_l2", "divergence_max", "nonsense", ""))
        name = name.replace("<quantity>", quantity)
        for place, words in self.places.items():
            name = name.replace(f"<{place}>", rng.choice(words))
        return name

    def bounds(self):
        """Returns the least and the largest value allowed, as numbers."""
        match = re.match(r"(\S+) to (\S+)$", self.allowed)
        if match:
            return float(match[1]), float(match[2])
        if self.allowed == "above 0":
            return 1e-300, 1e300
        match = re.match(r"(\S+) or more$", self.allowed)
        return (float(match[1]), 1e300) if match else (-1e300, 1e300)

    def words(self):
        """Returns the names from which the option chooses."""
        return re.sub(r"^(one|some) of ", "", self.allowed).split(", ")

    def setting(self, rng):
        """Returns options with which most runs read this one."""
        found = []
        for option, value in re.findall(r"(-[a-z_]+) ([a-z_]+)", self.where):
            if option != "-visc_ts_type":
                found += [option, value]
        if "bodies that are given" in self.where:
            found += ["-scene_body_1", "circle,0.5,0.5,0.2"]
        if "fluids that are given" in self.where:
            found += ["-scene_fluid_1", "circle,0.5,0.5,0.2", "-scene_fluid_1_viscosity", "0.1"]
        if "scalars that have a name" in self.where:
            found += ["-scene_scalar_1_name", "T", "-scene_scalar_1_diffusivity", "0.1"]
        if "with a probe" in self.where:
            found += ["-probe_point", "0.5,0.5"]
        if "not newtonian" in self.where:
            found += ["-rheology", "papanastasiou", "-rheology_yield", "0.1"]
        if "-rheology carreau" in self.where or "power\\_law" in self.where:
            found += ["-rheology_exponent", "0.5"]
        return found if rng.random() < 0.85 else []


def reference(isph):
    """Returns the options of the reference page, and the names of the cases."""
    text = subprocess.run([isph, "-options_reference"], stdout=subprocess.PIPE, text=True, check=True,
                          env=environment(os.getcwd())).stdout
    places = {}
    for place, words in re.findall(r"`<(\w+)>` stands for (.*)\.", text):
        places[place] = words.split(", ")
    rows = []
    for line in text.splitlines():
        if line.startswith("| `-"):
            cells = [re.sub(r"\\([_|>*])", r"\1", cell).strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
            assert len(cells) == 7, line
            cells[0] = cells[0].strip("`")
            rows.append(Option(cells, places))
    assert len(rows) > 100, text
    return rows, next(row for row in rows if row.name == "-case").words()
