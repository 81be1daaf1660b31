"""Which kinds of body can touch, against the scene's own word on each pair of bodies."""

from itertools import combinations

from hypothesis import given
from hypothesis import strategies as st

from plumbline.harness.adapter.touching_kinds import touching_kinds
from plumbline.harness.scene import Body, PlacedShape, Scene, Sphere, Surface

MATERIALS = ("ice", "oak", "tin")
PAIRS = [(a, b) for k, a in enumerate(MATERIALS) for b in MATERIALS[k:]]
BALL = (PlacedShape(shape=Sphere(radius=0.1)),)


@given(
    st.lists(st.tuples(st.sampled_from(MATERIALS), st.booleans(), st.booleans()), min_size=1, max_size=6),
    st.sets(st.sampled_from([(a, b) for a, b in PAIRS if a != b])),
)
def test_kinds_touch_just_where_two_bodies_of_them_collide(
    bodies: list[tuple[str, bool, bool]], apart: set[tuple[str, str]]
) -> None:
    made = tuple(
        Body(name=f"b{k}", material=material, motion="dynamic" if moves else "static", collision=BALL if solid else ())
        for k, (material, moves, solid) in enumerate(bodies)
    )
    named = {body.material for body in made}
    parted = {pair for pair in apart if named.issuperset(pair)}
    laws = tuple(
        Surface(between=pair, static_friction=k / 10, kinetic_friction=k / 10)
        for k, pair in enumerate(PAIRS)
        if pair not in parted
    )
    scene = Scene(bodies=made, surfaces=laws, apart=tuple(sorted(parted)))
    expected = {
        tuple(sorted(((a.material, a.movable), (b.material, b.movable)))): scene.surface(a, b)
        for a, b in combinations(made, 2)
        if scene.collides(a, b)
    }
    assert touching_kinds(scene) == expected
