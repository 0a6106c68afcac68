"""Many campaigns and bootstraps over executors; progress, and the end of long work."""

import os
import pickle
import signal
import threading
import time
from collections.abc import Callable
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import hydrosysid as hs
import matplotlib as mpl
import numpy as np
import pytest

mpl.use("Agg")

Listener = Callable[[str, int, int], object]


@pytest.fixture(scope="module")
def campaigns(campaign: hs.Campaign, runs: list[hs.Run]) -> list[hs.Campaign]:
    effects = ["inertia", "linear_drag", "quadratic_drag"]
    return [
        campaign,
        *(hs.Campaign(vehicle={"name": "a"}, dofs=["surge"], effects=effects, runs=[r]) for r in runs[:2]),
    ]


def test_every_executor_gives_what_a_loop_gives(campaigns: list[hs.Campaign]) -> None:
    serial = hs.map_fit(campaigns)
    heard: list[tuple[str, int, int]] = []
    with ThreadPoolExecutor(2) as threads:
        assert hs.map_fit(campaigns, executor=threads, progress=lambda *step: heard.append(step)) == serial
    assert heard == [("fitting campaigns", k, 3) for k in (1, 2, 3)]
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as processes:
        assert hs.map_fit(campaigns, executor=processes) == serial


def test_forked_workers_do_not_wait_for_threads_that_are_gone(campaigns: list[hs.Campaign]) -> None:
    serial = hs.map_fit(campaigns)  # the threads of this process have worked before it forks
    with ProcessPoolExecutor(1, mp_context=get_context("fork")) as processes:
        assert list(processes.map(hs.fit, campaigns, timeout=60)) == serial


def bootstrapped(campaign: hs.Campaign, executor: Executor | None = None, seed: int = 3) -> hs.Resampling:
    return hs.resample(
        campaign, method="runs", draws=24, block=15.0, seed=seed, estimator="integral", executor=executor
    )


@pytest.mark.filterwarnings("ignore")  # those of Dask's own start and end
def test_dask_gives_what_a_loop_gives(campaigns: list[hs.Campaign]) -> None:
    from distributed import Client

    local = {"processes": True, "n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
    with Client(**local) as client, client.get_executor() as executor:
        assert hs.map_fit(campaigns, executor=executor) == hs.map_fit(campaigns)
        assert bootstrapped(campaigns[0], executor) == bootstrapped(campaigns[0])


def test_bootstrap(campaign: hs.Campaign) -> None:
    found = bootstrapped(campaign)
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as processes:
        assert bootstrapped(campaign, processes) == found
    assert found.samples is not None
    assert found.draws == 24 - found.failed
    assert found.samples.shape == (found.draws, 3)
    fit = hs.fit(campaign, estimator="integral")
    for k, p in enumerate(found.parameters):
        assert p.value == fit[p.term].value
        assert p.interval == tuple(np.quantile(found.samples[:, k], [0.025, 0.975]).tolist())
        assert p.std == pytest.approx(float(np.std(found.samples[:, k], ddof=1)), rel=1e-12)
        assert p.std > 0.0
    assert bootstrapped(campaign, seed=4) != found
    assert pickle.loads(pickle.dumps(found)) == found
    assert "24 draws of stretches of 15 s" in found.summary()
    axes = found.plot("linear_drag@surge")
    assert found.plot("k_u", ax=axes) is axes
    axes.figure.clear()
    every = found.plot()
    assert next(t.get_text() for t in every.get_yticklabels()) == "inertia@surge m_u"
    every.figure.clear()
    with pytest.raises(KeyError, match="no parameter 'k_v'"):
        found.plot("k_v")


def test_a_bootstrap_needs_something_to_draw_from(campaigns: list[hs.Campaign]) -> None:
    with pytest.raises(hs.DataError, match="two runs or more"):
        hs.resample(campaigns[1], method="runs", draws=10)
    with pytest.raises(hs.UsageError, match="draws = 1"):
        hs.resample(campaigns[0], method="runs", draws=1)
    with pytest.raises(hs.UsageError, match="block, executor: only method = 'runs'"), ThreadPoolExecutor(1) as pool:
        hs.resample(campaigns[0], block=10.0, executor=pool)
    quick = hs.resample(campaigns[0], draws=20)
    with pytest.raises(hs.UsageError, match="no single draws"):
        quick.plot("k_u")


def test_discovery_says_what_it_does(campaign: hs.Campaign) -> None:
    heard: list[tuple[str, int, int]] = []
    hs.discover(campaign, progress=lambda what, done, of: heard.append((what, done, of)))
    words = [what for what, _, _ in heard]
    assert words[0] == "fitting the baseline"
    assert any(what.startswith("judging") for what in words)
    assert all(0 <= done <= max(of, done) for _, done, of in heard)


PUBLISHED = {"format": 1, "convention": "sname", "parameters": {"X_u|u|": -120.0}}
CALLS: dict[str, Callable[[hs.Campaign, hs.Fit, Path, Listener], object]] = {
    "from_file": lambda c, f, p, tell: hs.Campaign.from_file(p, progress=tell),
    "check": lambda c, f, p, tell: hs.check(p, progress=tell),
    "check of logs": lambda c, f, p, tell: hs.check(p.parent / "surge_1.csv", progress=tell),
    "fit": lambda c, f, p, tell: hs.fit(c, progress=tell),
    "fit of a file": lambda c, f, p, tell: hs.fit(p, progress=tell),
    "thorough fit": lambda c, f, p, tell: hs.fit(c, thorough=True, progress=tell),
    "simulate": lambda c, f, p, tell: hs.simulate(c, f, progress=tell),
    "force_components": lambda c, f, p, tell: hs.force_components(c, f, progress=tell),
    "compare": lambda c, f, p, tell: hs.compare(c, f, progress=tell),
    "compare without a model": lambda c, f, p, tell: hs.compare(c, progress=tell),
    "compare_published": lambda c, f, p, tell: hs.compare_published(c, PUBLISHED, f, progress=tell),
    "cross_validate": lambda c, f, p, tell: hs.cross_validate(c, progress=tell),
    "monitor": lambda c, f, p, tell: hs.monitor(c, f, progress=tell),
    "plan": lambda c, f, p, tell: hs.plan(c, most=1, length=30.0, rehearse=2, progress=tell),
    "resample": lambda c, f, p, tell: hs.resample(c, draws=3, progress=tell),
    "report": lambda c, f, p, tell: hs.report(c, p.parent / "page.html", discovery=False, force=True, progress=tell),
}


@pytest.fixture(scope="module")
def fitted(campaign: hs.Campaign) -> hs.Fit:
    return hs.fit(campaign)


@pytest.mark.parametrize("name", list(CALLS))
def test_every_long_call_says_what_it_does(name: str, campaign: hs.Campaign, fitted: hs.Fit, folder: Path) -> None:
    heard: list[tuple[str, int, int]] = []

    def tell(what: str, done: int, of: int) -> None:
        heard.append((what, done, of))

    CALLS[name](campaign, fitted, folder / "campaign.toml", tell)
    assert heard
    assert all(what and done >= 0 and (of == 0 or done <= of) for what, done, of in heard)

    def enough(what: str, done: int, of: int) -> None:
        raise StopIteration("enough")

    with pytest.raises(StopIteration, match="enough"):
        CALLS[name](campaign, fitted, folder / "campaign.toml", enough)


def test_steps_of_a_fit_are_counted(campaign: hs.Campaign) -> None:
    heard: list[tuple[str, int, int]] = []
    hs.fit(campaign, progress=lambda what, done, of: heard.append((what, done, of)))
    steps = [done for what, done, of in heard if what == "fitting by filter error" and of == 0]
    assert len(steps) > 3
    assert steps[1:] == sorted(set(steps[1:]))


def test_a_demo_says_what_it_does_and_can_be_ended(tmp_path: Path) -> None:
    heard: list[str] = []

    def until_staged(what: str, done: int, of: int) -> None:
        heard.append(what)
        if "staged" in what:
            raise StopIteration("enough")

    with pytest.raises(StopIteration, match="enough"):
        hs.demo(tmp_path / "demo", progress=until_staged)
    assert "sailing the paper's runs" in heard


def test_a_bar_of_tqdm(campaign: hs.Campaign, capsys: pytest.CaptureFixture[str]) -> None:
    hs.discover(campaign, progress=True)
    assert "judging" in capsys.readouterr().err


@pytest.fixture(scope="module")
def long(tmp_path_factory: pytest.TempPathFactory) -> hs.Campaign:
    """A campaign whose discovery takes some seconds."""
    return hs.tank_campaign(tmp_path_factory.mktemp("tank") / "tank", seed=1)


def test_what_progress_raises_ends_the_work(long: hs.Campaign) -> None:
    def enough(what: str, done: int, of: int) -> None:
        raise StopIteration("enough")

    with pytest.raises(StopIteration, match="enough"):
        hs.discover(long, progress=enough)


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_control_c_ends_a_long_verb_and_other_threads_go_on(campaign: hs.Campaign) -> None:
    turns = 0
    pressed = 0.0
    done = threading.Event()

    def other() -> None:
        nonlocal turns, pressed
        until = time.monotonic() + 1.5
        while time.monotonic() < until:
            turns += 1
            time.sleep(0.001)
        pressed = time.monotonic()
        os.kill(os.getpid(), signal.SIGINT)
        done.wait(60)

    # what runs in the background of a shell ignores the key, and Python leaves it so
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    thread = threading.Thread(target=other)
    thread.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            # many minutes, were it not for the interrupt
            hs.resample(campaign, method="monte_carlo", draws=1_000_000)
        waited = time.monotonic() - pressed
    finally:
        done.set()
        thread.join()
        signal.signal(signal.SIGINT, before)
    assert turns > 50  # the lock was let go of
    assert pressed > 0.0
    assert waited < 20.0  # against many minutes; a machine may be busy
