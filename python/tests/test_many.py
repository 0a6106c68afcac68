"""Many campaigns and bootstraps over executors; progress, and the end of long work."""

import os
import pickle
import signal
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import nullcontext
from itertools import pairwise
from multiprocessing import get_context
from pathlib import Path
from typing import Any, Literal

import hydrosysid as hs
import matplotlib as mpl
import numpy as np
import pytest
from hydrosysid._workers import mapped, mapped_or_failed

mpl.use("Agg")

import matplotlib.pyplot as plt
from matplotlib.patches import Rectangle

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
    assert heard == [("fitting campaigns", k, 3) for k in (0, 1, 2, 3)]
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as processes:
        assert hs.map_fit(campaigns, executor=processes) == serial


def shifted(bad: int) -> hs.Campaign:
    """A campaign that no fit can do anything with: nothing drives it."""
    t = np.arange(600) * 0.1
    run = hs.Run(t=t, u=np.full(600, 0.3 + bad), tau_u=np.zeros(600))
    return hs.Campaign(vehicle={"name": "idle"}, dofs=["surge"], effects=["inertia", "linear_drag"], runs=[run])


def test_a_failure_stays_with_its_campaign(campaigns: list[hs.Campaign], folder: Path, tmp_path: Path) -> None:
    absent = tmp_path / "absent.toml"
    mixed = [campaigns[0], shifted(0), folder / "campaign.toml", absent]
    found = hs.map_fit(mixed)
    assert [type(result).__name__ for result in found] == ["Fit", "DataError", "Fit", "UsageError"]
    assert list(found.failures) == [1, 3]
    assert str(absent) in str(found[3])
    assert found.names == ("small", "idle", folder.name, f"{folder.name}/absent.toml")
    first = hs.fit(campaigns[0])
    assert found[0] == first
    assert found.params.iloc[0].to_dict() == first.params.to_dict()
    assert found.params.iloc[1].isna().all()
    assert found.bse.iloc[2].tolist() == [p.std for p in hs.fit(folder / "campaign.toml").parameters]
    table = found.to_frame("pandas")
    assert len(table) == 3 + 1 + 3 + 1
    assert table["error"].notna().sum() == 2
    assert "2 of 4 fitted, 2 failed" in found.summary()
    assert found.to_dict()["fits"][1]["error"] == str(found[1]).splitlines()[0]
    again = pickle.loads(pickle.dumps(found))
    assert again == found
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as processes:
        assert hs.map_fit(mixed, executor=processes) == found
    assert found.plot("k_u").get_ylabel() == "k_u, kg/s"
    with pytest.raises(KeyError, match="linear_drag@surge"):
        found.plot("k_v")
    plt.close("all")


def test_progress_tells_what_is_done_first() -> None:
    """The second of two is done while the first one waits for it to be heard of."""
    heard: list[int] = []
    second_is_heard = threading.Event()

    def work(item: int) -> int:
        if item == 0:
            assert second_is_heard.wait(60)
        return 10 * item

    def tell(what: str, done: int, of: int) -> None:
        heard.append(done)
        if done == 1:
            second_is_heard.set()

    with ThreadPoolExecutor(2) as threads:
        assert mapped(work, [0, 1], threads, "working", tell) == [0, 10]
    assert heard == [0, 1, 2]


def test_a_worker_that_raises_ends_the_rest() -> None:
    def work(item: int) -> int:
        if item == 1:
            raise ZeroDivisionError("one")
        return item

    for threads in (None, ThreadPoolExecutor(1)):
        with pytest.raises(ZeroDivisionError, match="one"):
            mapped(work, range(3), threads, "working", None)
        kept = mapped_or_failed(work, range(3), threads, "working", None)
        assert [kept[0], str(kept[1]), kept[2]] == [0, "one", 2]


def test_what_is_no_executor_is_told(campaigns: list[hs.Campaign]) -> None:
    with pytest.raises(hs.UsageError, match=r"executor = int: a concurrent\.futures\.Executor or a Dask Client"):
        hs.map_fit(campaigns, executor=3)  # type: ignore[arg-type]


def test_what_is_no_campaign_stays_in_its_place(campaigns: list[hs.Campaign], folder: Path) -> None:
    mixed: list[Any] = [3, campaigns[1], None, folder]
    found = hs.map_fit(mixed)
    assert [type(result).__name__ for result in found] == ["UsageError", "Fit", "UsageError", "Fit"]
    assert str(found[0]) == "campaigns[0] = 3: a campaign, or the path of one, is expected"
    assert "campaigns[2] = None" in str(found[2])
    assert found.names == ("campaigns[0]", "a", "campaigns[2]", folder.name)
    with ThreadPoolExecutor(2) as threads:
        assert hs.map_fit(mixed, executor=threads) == found


def test_a_single_campaign_is_no_list_of_them(campaigns: list[hs.Campaign], folder: Path) -> None:
    path = folder / "campaign.toml"
    for single in (str(path), path, campaigns[0]):
        with pytest.raises(hs.UsageError, match=r"^campaigns = .*a list of campaigns.*one campaign is fitted by fit"):
            hs.map_fit(single)  # type: ignore[arg-type]
    with pytest.raises(hs.UsageError, match="campaigns = 3: a list of campaigns"):
        hs.map_fit(3)  # type: ignore[arg-type]


class Broken(ThreadPoolExecutor):
    """A pool that takes one piece of work, which it never begins, and no more."""

    def __init__(self) -> None:
        super().__init__(1)
        self.taken: list[Future[Any]] = []

    def submit(self, *work: Any, **options: Any) -> Future[Any]:
        if self.taken:
            raise BrokenExecutor("a worker ended")
        self.taken.append(Future())
        return self.taken[0]


def test_a_pool_that_takes_no_more_work_leaves_its_error() -> None:
    heard: list[int] = []
    ended = ThreadPoolExecutor(1)
    ended.shutdown()
    kept = mapped_or_failed(abs, [-1, -2], ended, "working", lambda what, done, of: heard.append(done))
    assert [type(error) for error in kept] == [RuntimeError, RuntimeError]
    assert heard == [0, 2]
    broken = Broken()
    with pytest.raises(BrokenExecutor, match="a worker ended"):
        mapped(abs, [-1, -2], broken, "working", None)
    assert broken.taken[0].cancelled()


def test_a_campaign_of_a_file_crosses_as_its_whole_path(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    campaign = hs.Campaign.from_file("campaign.toml")
    packed = pickle.dumps(campaign)
    assert len(packed) < 400  # the path, and none of the logs
    monkeypatch.chdir("/")
    assert pickle.loads(packed).runs == campaign.runs


def test_a_campaign_in_memory_crosses_as_its_arrays(campaign: hs.Campaign, runs: list[hs.Run]) -> None:
    # stamps that channels share cross once
    arrays = {id(a): a.nbytes for run in runs for pair in run.signals.values() for a in pair}
    assert sum(arrays.values()) < len(pickle.dumps(campaign)) < sum(arrays.values()) + 4_000


def test_forked_workers_do_not_wait_for_threads_that_are_gone(campaigns: list[hs.Campaign]) -> None:
    serial = hs.map_fit(campaigns)  # the threads of this process have worked before it forks
    with ProcessPoolExecutor(1, mp_context=get_context("fork")) as processes:
        assert list(processes.map(hs.fit, campaigns, timeout=60)) == list(serial)


def bootstrapped(campaign: hs.Campaign, executor: Any = None, seed: int = 3) -> hs.Resampling:
    return hs.resample(
        campaign, method="runs", draws=24, block=15.0, seed=seed, estimator="integral", executor=executor
    )


@pytest.mark.filterwarnings("ignore")  # those of Dask's own start and end
def test_dask_gives_what_a_loop_gives(campaigns: list[hs.Campaign]) -> None:
    from distributed import Client

    local = {"processes": True, "n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
    serial = hs.map_fit(campaigns)
    with Client(**local) as client, client.get_executor() as executor:
        assert hs.map_fit(campaigns, executor=client) == serial
        assert hs.map_fit(campaigns, executor=executor) == serial
        assert bootstrapped(campaigns[0], client) == bootstrapped(campaigns[0])


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
    with pytest.raises(hs.UsageError, match="block: only method = 'runs'"):
        hs.resample(campaigns[0], block=10.0)


@pytest.mark.parametrize("method", ["bootstrap", "monte_carlo"])
@pytest.mark.parametrize("estimator", ["filter_error", "output_error", "integral"])
def test_refits_are_the_same_whoever_makes_them(
    campaign: hs.Campaign,
    method: Literal["bootstrap", "monte_carlo"],
    estimator: Literal["filter_error", "output_error", "integral"],
) -> None:
    def drawn(seed: int | None, executor: Executor | None = None) -> hs.Resampling:
        return hs.resample(campaign, method=method, estimator=estimator, draws=21, seed=seed, executor=executor)

    alone = drawn(5)
    with ThreadPoolExecutor(2) as threads:  # lots of 8, 8 and 5
        shared = drawn(5, threads)
    assert shared == alone
    assert shared.samples is not None
    assert alone.samples is not None
    np.testing.assert_array_equal(shared.samples, alone.samples)
    assert alone.samples.shape == (alone.draws, 3)
    for k, p in enumerate(alone.parameters):
        assert p.mean == pytest.approx(float(alone.samples[:, k].mean()), rel=1e-12)
        assert p.std == pytest.approx(float(alone.samples[:, k].std(ddof=1)), rel=1e-9)
        assert p.interval == pytest.approx(tuple(np.quantile(alone.samples[:, k], [0.025, 0.975])), rel=1e-12)
    other = drawn(6)
    assert (alone.seed, other.seed) == (5, 6)
    assert other.parameters != alone.parameters
    assert drawn(None).seed == 1  # that of the campaign
    axes = alone.plot("k_u")
    assert sum(patch.get_height() for patch in axes.patches if isinstance(patch, Rectangle)) >= alone.draws
    plt.close("all")


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


def test_progress_without_tqdm_is_a_line(
    campaign: hs.Campaign, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "tqdm", None)
    hs.discover(campaign, progress=True)
    told = capsys.readouterr().err
    assert "\rfitting the baseline" in told
    assert "judging" in told
    # each state covers the one before, and the last leaves nothing
    states = told.split("\r")[1:]
    assert states[-1] == ""
    assert states[-2].isspace()
    assert all(len(after) >= len(before.rstrip()) for before, after in pairwise(states[:-1]))
    hs.map_fit([campaign, campaign], progress=True)
    assert "fitting campaigns 2 of 2 (100 %)" in capsys.readouterr().err


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


EXECUTORS: dict[str, Callable[[], Any]] = {
    "loop": lambda: nullcontext(None),
    "threads": lambda: ThreadPoolExecutor(1),
    "processes": lambda: ProcessPoolExecutor(1, mp_context=get_context("spawn")),
}


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
@pytest.mark.parametrize("name", EXECUTORS)
def test_control_c_ends_many_fits(name: str, campaign: hs.Campaign) -> None:
    """The key is pressed when the first fit is heard of: no other is waited for, and the executor can be used again."""
    heard: list[int] = []

    def press(what: str, done: int, of: int) -> None:
        heard.append(done)
        if done == 1:
            signal.raise_signal(signal.SIGINT)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with EXECUTORS[name]() as executor:
            with pytest.raises(KeyboardInterrupt):
                hs.map_fit([campaign] * 40, executor=executor, progress=press)
            assert heard == [0, 1]
            if executor is not None:
                # one at work and one on its way to a process: the others are called off
                assert executor.submit(abs, -3).result(60) == 3
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_control_c_ends_init(tmp_path: Path) -> None:
    """By the CPU that the whole takes and that until the end: a busy machine changes neither."""
    motion = [",".join(f"{np.sin(k / (50.0 + j)):.6f}" for j in range(7)) for k in range(1000)]
    log, written = tmp_path / "dive.csv", tmp_path / "mine.toml"
    log.write_text("t,u,v,w,p,q,r,tau_u\n" + "".join(f"{0.02 * k:.2f},{motion[k % 1000]}\n" for k in range(600_000)))
    begin = time.process_time()
    hs.init([log])
    whole = time.process_time() - begin
    main = threading.main_thread().ident
    assert main is not None

    def press() -> None:
        while (frame := sys._current_frames()[main]).f_code.co_name != "scaffold":
            time.sleep(0.001)
        del frame
        os.kill(os.getpid(), signal.SIGINT)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    thread = threading.Thread(target=press)
    begin = time.process_time()
    thread.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            hs.init([log], written)
    finally:
        thread.join()
        signal.signal(signal.SIGINT, before)
    assert time.process_time() - begin < 0.5 * whole
    assert not written.exists()


def test_an_export_that_is_ended_leaves_what_was_there(fitted: hs.Fit, tmp_path: Path) -> None:
    path = tmp_path / "model.csv"
    hs.export(fitted, "csv", path)
    there = path.read_bytes()
    assert there == hs.export(fitted, "csv").content

    def half(self: Path, data: bytes) -> int:
        with self.open("wb") as file:
            file.write(data[: len(data) // 2])
        raise KeyboardInterrupt

    patch = pytest.MonkeyPatch()
    patch.setattr(Path, "write_bytes", half)
    with patch.context(), pytest.raises(KeyboardInterrupt):
        hs.export(fitted, "latex", path)
    patch.undo()
    assert path.read_bytes() == there
    assert list(tmp_path.iterdir()) == [path]


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
