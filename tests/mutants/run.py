#!/usr/bin/env python3
"""Breaks a copy of the sources in ways that bias an estimator, one at a time, and sees the tests fail.

Usage: run.py FOLDER [NAME...]: the copy and its build lie in FOLDER; with names, only those mutants.
Ends 0 when every mutant was caught; otherwise says which survived, no longer applies, or does not build.
"""

import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
COPIED = ["CMakeLists.txt", "app", "assets", "cmake", "renderer", "shaders", "tests"]

HALFLIGHT = [("techniques_halflight_density", "*OneDensity*"),
             ("techniques_halflight", "*KeepTheMean*:*ShineInSpots*")]
DISTRIBUTION = ("lights_cut_distribution", "*")
CONTRACT = ("techniques_contract", "*EveryLights*:*DrawsFollow*")
TRACED = ("techniques_traced", "*")

# Name, what is broken, [(file, text that must stand there once, what it becomes)], tests of which one must fail.
MUTANTS = [
    ("no-guard", "alpha = tau = 0", [
        ("renderer/techniques/bidirectional.cpp",
         'static_cast<float>(values.get("bidirectional.tau"))', "0.0f"),
        ("renderer/techniques/bidirectional.cpp",
         'static_cast<float>(values.get("bidirectional.alpha"))', "0.0f"),
    ], [CONTRACT]),
    ("counting-rays-reused", "what counting rays met becomes samples", [
        ("renderer/techniques/counted_cut.h", "    distribution_.draw(*cut_, random, out);\n",
         """    distribution_.draw(*cut_, random, out);
    for (size_t j = 0; j < std::min(out.size(), counted_.size()); ++j) {
      const uint32_t k = counted_[j].cluster, count = cut_->end[k] - cut_->begin[k];
      const uint32_t leaf = cut_->begin[k] + static_cast<uint32_t>(random.next_bits() % count);
      if (distribution_.probability(*cut_, k, leaf) > 0)
        out[j] = {leaf, distribution_.weight(*cut_, k, leaf)};
    }
"""),
        ("renderer/techniques/counted_cut.h", "  ClusterCounter counter_;\n",
         "  ClusterCounter counter_;\n  std::vector<ClusterCounter::Count> counted_;\n"),
        ("renderer/techniques/counted_cut.cpp", "      importance[k] += cut_->radiance[k] * scale * hits;\n",
         "      importance[k] += cut_->radiance[k] * scale * hits, counted_.push_back({k, hits});\n"),
        ("renderer/techniques/counted_cut.cpp", "  const std::span<float> importance =",
         "  counted_.clear();\n  const std::span<float> importance ="),
    ], [CONTRACT]),
    ("current-set", "weights from the set in hand", [
        ("renderer/techniques/learned_lights.cpp",
         "  for (size_t i = 0; i < set.size(); ++i) lights_[i] = set[tree_.original[i]];\n",
         """  for (size_t i = 0; i < set.size(); ++i) lights_[i] = set[tree_.original[i]];
  seen_ = {};
  see(set, seen_);
  use_powers();
  refresh_cut(tree_, cut_);
"""),
    ], HALFLIGHT),
    ("another-p-discrete", "leaves drawn by power, weighed as if alike", [
        ("renderer/lights/cut_distribution.cpp",
         "out[j] = {leaf, cluster_weight[j] * leaves[leaf].inverse_share, draws.cluster[j]};",
         """const uint32_t k = draws.cluster[j];
    out[j] = {leaf, weight_in_cluster(total, draws.share[j], cut.end[k] - cut.begin[k]), k};"""),
    ], [DISTRIBUTION, CONTRACT]),
    ("another-p-continuous", "what rays meet is weighed as if leaves were drawn alike", [
        ("renderer/techniques/traced_loop.h", "distribution->probability(lights->cut(), cluster, met->leaf)",
         "distribution->cluster_probability(cluster) /\n                              (lights->cut().end[cluster] - lights->cut().begin[cluster])"),
    ], HALFLIGHT),
    ("no-cosine-of-light", "a light's own cosine is missing in the sum", [
        ("renderer/techniques/connection_batch.cpp", "(faces > 0.0f ? faces : 0.0f)", "(faces > 0.0f ? 1.0f : 0.0f)"),
    ], [*HALFLIGHT, ("techniques_contract", "*MeanIsTheExactSum*")]),
    ("no-cosine-in-density", "a surface's cosine is missing in the density of what a ray met", [
        ("renderer/techniques/traced_loop.cpp", "area_to_solid_angle(density, ray.hit.distance, place.cos_light)",
         "area_to_solid_angle(density, ray.hit.distance, 1)"),
    ], HALFLIGHT),
    ("no-cosine-of-point", "the shaded point's cosine is missing", [
        ("renderer/techniques/traced_loop.cpp", "drawn->f * (glm::dot(texel_->shading_normal, drawn->wi) / drawn->pdf * scale_)",
         "drawn->f * (1 / drawn->pdf * scale_)"),
    ], [*HALFLIGHT, TRACED]),
    ("next-leaf", "the search in the running sums is off by one", [
        ("renderer/lights/cut_distribution.cpp", "    while (leaves[leaf].end <= target[j]) ++leaf;\n",
         "    leaf = std::min(leaf + 1, cut.end[draws.cluster[j]] - 1);\n"),
    ], [DISTRIBUTION, CONTRACT]),
    ("part-of-the-whole", "a part of a cluster draws from where the whole begins", [
        ("renderer/lights/cut.cpp", "  part.start = cut.sum_before(begin);\n", ""),
    ], [("lights_tile_cut", "*"), CONTRACT]),
]


class Failure(Exception):
    pass


def copy_sources(source):
    """Brings the copy up to date; files that have not changed keep their times: little is built again."""
    for name in COPIED:
        origin = ROOT / name
        files = [origin] if origin.is_file() else [p for p in origin.rglob("*") if p.is_file()]
        for file in files:
            target = source / file.relative_to(ROOT)
            if target.exists() and target.read_bytes() == file.read_bytes():
                continue
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, target)
            shutil.copymode(file, target)


def configure(source, build):
    command = ["cmake", "-S", str(source), "-B", str(build), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release"]
    if shutil.which("ccache"):
        command.append("-DCMAKE_CXX_COMPILER_LAUNCHER=ccache")
    run_quietly(command, "configuring failed")


def run_quietly(command, complaint):
    result = subprocess.run(command, capture_output=True, text=True)
    if result.returncode != 0:
        raise Failure(f"{complaint}:\n{result.stdout[-4000:]}{result.stderr[-4000:]}")


def build_tests(build, tests):
    targets = sorted({f"test_{name}" for name, _ in tests})
    run_quietly(["cmake", "--build", str(build), "--target", *targets], "it does not build")


def failing_tests(build, tests):
    """Names of the tests that fail; a crash counts as the test's executable."""
    failed = []
    for name, pattern in tests:
        command = [str(build / "tests" / f"test_{name}"), f"--gtest_filter={pattern}", "--gtest_brief=1"]
        result = subprocess.run(command, capture_output=True, text=True, errors="replace")
        if "[  PASSED  ]" not in result.stdout and result.returncode == 0:
            raise Failure(f"{name} ran no test")
        found = re.findall(r"^\[  FAILED  \] ([\w/.]+)(?:, where.*)? \(\d+ ms\)", result.stdout, re.MULTILINE)
        if result.returncode != 0 and not found:
            found = [f"(ended with {result.returncode})"]
        failed += [f"{name}: {test}" for test in dict.fromkeys(found)]
    return failed


def apply(source, edits):
    """Returns the files as they were."""
    before = {}
    for name, old, new in edits:
        path = source / name
        text = path.read_text()
        before.setdefault(path, text)
        if text.count(old) != 1:
            restore(before)
            raise Failure(f"it no longer applies: {name} has {text.count(old)} times\n{old}")
        path.write_text(text.replace(old, new))
    return before


def restore(before):
    for path, text in before.items():
        path.write_text(text)


def try_mutant(source, build, mutant):
    name, what, edits, tests = mutant
    before = apply(source, edits)
    try:
        build_tests(build, tests)
        failed = failing_tests(build, tests)
    finally:
        restore(before)
    if not failed:
        raise Failure("it survived: no test fails")
    print(f"{name} ({what}): caught by {len(failed)}, the first {failed[0]}", flush=True)


def main():
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    folder = pathlib.Path(sys.argv[1]).resolve()
    source, build = folder / "source", folder / "build"
    chosen = [m for m in MUTANTS if len(sys.argv) == 2 or m[0] in sys.argv[2:]]
    if not chosen:
        sys.exit("no mutant of that name; there are " + ", ".join(m[0] for m in MUTANTS))
    tests = list(dict.fromkeys(test for mutant in chosen for test in mutant[3]))
    wrong = []
    try:
        copy_sources(source)
        configure(source, build)
        build_tests(build, tests)
        failed = failing_tests(build, tests)
        if failed:
            raise Failure("tests fail before anything is broken: " + ", ".join(failed))
    except Failure as failure:
        sys.exit(f"mutants: {failure}")
    for mutant in chosen:
        try:
            try_mutant(source, build, mutant)
        except Failure as failure:
            print(f"{mutant[0]} ({mutant[1]}): {failure}", flush=True)
            wrong.append(mutant[0])
    if wrong:
        sys.exit("mutants not caught: " + ", ".join(wrong))


if __name__ == "__main__":
    main()
