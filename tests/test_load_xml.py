"""COLLADA and 3MF: transforms, shared parts, up axes and units, by hand."""

from __future__ import annotations

import numpy as np
import pytest
from load_support import area, corners, loaded, warned, zipped

from shadowlab.errors import ArgumentError, LoadError
from shadowlab.scene.formats.limits import Limits

XYZ = '<accessor source="#{0}a" count="{1}" stride="3"><param name="X"/><param name="Y"/><param name="Z"/></accessor>'
U = "0 3 0 3 3 0 3 0 0 2 0 0 2 2 0 1 2 0 1 0 0 0 0 0"
ONCE = '<instance_geometry url="#g"/>'
TWICE = f'<node id="a">{ONCE}</node><node><translate>10 0 0</translate>{ONCE}</node>'
INPUT = '<input semantic="VERTEX" source="#v" offset="0"/>'
POLY = f'<polylist count="1">{INPUT}<vcount>8</vcount><p>0 1 2 3 4 5 6 7</p></polylist>'


def dae(primitives=POLY, nodes='<node><instance_geometry url="#g"/></node>', asset="", more="", points=U):
    """A COLLADA document of one geometry."""
    count = len(points.split())
    return (
        '<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">'
        f"<asset>{asset}</asset><library_geometries><geometry id='g'><mesh><source id='s'><float_array id='sa' "
        f"count='{count}'>{points}</float_array>"
        f"<technique_common>{XYZ.format('s', count // 3)}</technique_common></source>"
        f"<vertices id='v'><input semantic='POSITION' source='#s'/></vertices>{primitives}</mesh></geometry>"
        f"</library_geometries>{more}<library_visual_scenes><visual_scene id='w'>{nodes}</visual_scene>"
        "</library_visual_scenes><scene><instance_visual_scene url='#w'/></scene></COLLADA>"
    )


def primitive(kind, *lists, before=""):
    """A primitive whose vertices are the second of two indices."""
    inputs = '<input semantic="NORMAL" source="#s" offset="0"/><input semantic="VERTEX" source="#v" offset="1"/>'
    pairs = "".join(f"<p>{' '.join(f'0 {i}' for i in one.split())}</p>" for one in lists)
    return f"<{kind}>{inputs}{before}{pairs}</{kind}>"


@pytest.mark.parametrize(
    ("primitives", "triangles", "expected"),
    [
        (POLY, 6, 7),
        (primitive("polygons", "0 1 2 3 4 5 6 7", "0 2 7"), 7, 7 + 4.5),
        (primitive("polylist", "0 1 2 3 4 5 6 7 0 2 7", before="<vcount>8 3</vcount>"), 7, 7 + 4.5),
        (primitive("triangles", "0 1 2 0 2 7"), 2, 9),
        (primitive("tristrips", "1 0 2 7", "0 1 2"), 3, 13.5),
        (primitive("trifans", "0 1 2 7", "0 1 2"), 3, 13.5),
        (primitive("triangles", "0 1 2") + primitive("tristrips", "0 2 7"), 2, 9),
        (
            f"<polygons>{INPUT}<ph><p>0 1 2 7</p><h>4 5 6 3</h></ph></polygons>",
            6,
            7,
        ),
    ],
)
def test_every_primitive_of_collada(primitives, triangles, expected):
    scene = loaded(dae(primitives), "dae")
    assert (scene.triangle_count, area(scene)) == (triangles, pytest.approx(expected))


def test_references_may_be_percent_encoded():
    text = dae().replace("id='g'", "id='g 1'").replace('"#g"', '"#g%201"').replace("id='s'", "id='s/1'")
    assert area(loaded("\n " + text.replace("'#s'", "'#s%2F1'"), "dae")) == pytest.approx(7)


def test_lines_are_left_out_and_told():
    scene, said = warned(dae(POLY + primitive("lines", "0 1")), "dae")
    assert scene.triangle_count == 6
    assert "g (lines)" in said


def test_transforms_in_their_order():
    moves = "<translate>5 0 0</translate><rotate>0 0 1 90</rotate><scale>2 1 1</scale>"
    nodes = f"<node>{moves}<node><matrix>1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1</matrix>{ONCE}</node></node>"
    scene = loaded(dae(primitive("triangles", "0 1 2"), nodes), "dae")
    expected = [[5 - y, 2 * (x + 1), 0] for x, y in ((0, 3), (3, 3), (3, 0))]
    np.testing.assert_allclose(corners(scene)[0], expected, atol=1e-12)
    nodes = "<node><lookat>0 0 5 0 0 0 0 1 0</lookat><instance_geometry url='#g'/></node>"
    np.testing.assert_allclose(loaded(dae(nodes=nodes), "dae").bounds, [[0, 0, 5], [3, 3, 5]], atol=1e-12)
    nodes = "<node><skew>45 0 1 0 1 0 0</skew><instance_geometry url='#g'/></node>"
    np.testing.assert_allclose(loaded(dae(nodes=nodes), "dae").bounds, [[0, 0, 0], [6, 3, 0]], atol=1e-12)


def test_nodes_share_geometry_and_other_nodes():
    scene = loaded(dae(nodes=TWICE + "<node><translate>0 20 0</translate><instance_node url='#a'/></node>"), "dae")
    assert (scene.mesh_count, scene.instance_count) == (1, 3)
    np.testing.assert_array_equal(scene.bounds, [[0, 0, 0], [13, 23, 0]])


def test_skins_are_taken_at_rest():
    skin = (
        "<library_controllers><controller id='c'><skin source='#g'><bind_shape_matrix>1 0 0 0 0 1 0 0 0 0 1 4 0 0 0 1"
        "</bind_shape_matrix></skin></controller></library_controllers>"
    )
    scene, said = warned(dae(nodes="<node><instance_controller url='#c'/></node>", more=skin), "dae")
    assert "at rest" in said
    np.testing.assert_array_equal(scene.bounds, [[0, 0, 4], [3, 3, 4]])


def test_references_that_lead_elsewhere():
    scene, said = warned(dae(nodes=TWICE + "<node><instance_geometry url='other.dae#g'/></node>"), "dae")
    assert scene.instance_count == 2
    assert "other.dae#g" in said
    circle = "<node id='n'><instance_geometry url='#g'/><instance_node url='#n'/></node>"
    with pytest.raises(LoadError, match="do not contain themselves"):
        loaded(dae(nodes=circle), "dae")
    bomb = "".join(
        f"<node id='n{k}'><instance_node url='#n{k + 1}'/><instance_node url='#n{k + 1}'/></node>" for k in range(60)
    )
    with pytest.raises(LoadError, match=r"at most 1,000,000 placed meshes, got 2,305,843,"):
        loaded(dae(nodes=bomb + "<node id='n60'><instance_geometry url='#g'/></node>"), "dae")
    # As many nodes without meshes are no work.
    assert warned(dae(nodes=bomb + "<node id='n60'/>" + TWICE), "dae")[0].instance_count == 2


UP = {"X_UP": [[-3, 0, 0], [0, 3, 0]], "Y_UP": [[0, 0, 0], [3, 3, 0]], "Z_UP": [[0, 0, -3], [3, 0, 0]]}


@pytest.mark.parametrize("word", UP)
def test_up_axis_and_unit_of_collada(word):
    asset = f"<unit name='inch' meter='0.0254'/><up_axis>{word}</up_axis>"
    scene = loaded(dae(asset=asset), "dae")
    np.testing.assert_allclose(scene.bounds, np.multiply(UP[word], 0.0254), atol=1e-12)
    assert scene.taken == f"{word[0].lower()} up, 0.0254 m per unit"
    assert scene.taken in repr(scene)
    assert scene.taken in scene._repr_html_()
    moved = scene.world_from_source @ (1, 2, 3, 1)
    axes = {"X_UP": (-2, 1, 3), "Y_UP": (1, 2, 3), "Z_UP": (1, 3, -2)}
    np.testing.assert_allclose(moved[:3], np.multiply(axes[word], 0.0254))
    plain = loaded(dae(asset=asset), "dae", up="y", unit=1)
    np.testing.assert_allclose(plain.bounds, UP["Y_UP"], atol=1e-12)
    turned = loaded(dae(asset=asset), "dae", up="z", unit="cm")
    np.testing.assert_allclose(turned.bounds, np.multiply(UP["Z_UP"], 0.01), atol=1e-12)
    assert turned.taken == "z up, 0.01 m per unit"


def test_a_file_that_says_nothing_is_taken_as_it_is():
    scene = loaded(dae(), "dae")
    assert scene.taken == ""
    np.testing.assert_array_equal(scene.world_from_source, np.eye(4))


@pytest.mark.parametrize("unit", [0, -1, np.nan, np.inf, True, "parsec", [1], "0.1"])
def test_units_that_are_none(unit):
    with pytest.raises(ArgumentError, match="unit: expected metres per unit"):
        loaded(dae(), "dae", unit=unit)


@pytest.mark.parametrize(
    ("text", "match"),
    [
        (dae(asset="<unit meter='0'/>"), "unit of finite metres"),
        (dae(asset="<unit meter='x'/>"), "metres of its unit"),
        (dae(asset="<up_axis>W_UP</up_axis>"), "X_UP, Y_UP or Z_UP"),
        (dae(points=U + " x"), "numbers for positions"),
        (dae(points="0 0 0"), "from 0 to 0"),
        (dae(primitive("triangles", "0 1 -1")), "from 0 to 7, got -1"),
        (dae(primitive("triangles", "0 1")), "corners in triangles"),
        (dae(primitive("polylist", "0 1 2", before="<vcount>4</vcount>")), "expected 4 corners"),
        (dae(primitive("triangles", "0 1 2").replace("VERTEX", "TANGENT")), "input VERTEX"),
        (dae(nodes="<node><translate>1 2</translate></node>"), "3 numbers for translate"),
        (dae().replace("url='#w'", "url='#x'"), "expected the scene '#x'"),
        (dae().replace("</COLLADA>", ""), "well-formed"),
        ("<html/>", "expected a COLLADA document"),
        ('<!DOCTYPE a [<!ENTITY b "c">]>' + dae()[21:], "document type"),
        ("<COLLADA>" + "<a>" * 100_000, "well-formed"),
    ],
)
def test_collada_that_is_refused(text, match):
    with pytest.raises(LoadError, match=match):
        loaded(text, "dae")


MESH = (
    '<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="2" y="0" z="0"/><vertex x="0" y="2" z="0"/></vertices>'
    '<triangles><triangle v1="0" v2="1" v3="2"/></triangles></mesh>'
)
CORE = 'xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"'
PRODUCTION = 'xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06"'


def model(resources, build, unit=""):
    """The text of a 3MF model."""
    unit = f'unit="{unit}"' if unit else ""
    return f"<model {unit} {CORE} {PRODUCTION}><resources>{resources}</resources><build>{build}</build></model>"


def package(resources, build, unit="", **files):
    """A 3MF package."""
    return zipped({"3D/3dmodel.model": model(resources, build, unit), **files})


PART = f'<object id="1">{MESH}</object>'


@pytest.mark.parametrize(
    ("unit", "metres"),
    [
        ("", 1e-3),
        ("micron", 1e-6),
        ("millimeter", 1e-3),
        ("centimeter", 1e-2),
        ("inch", 0.0254),
        ("foot", 0.3048),
        ("meter", 1),
    ],
)
def test_units_of_3mf(unit, metres):
    scene = loaded(package(PART, '<item objectid="1"/>', unit), "3mf")
    np.testing.assert_allclose(scene.bounds, np.multiply([[0, 0, 0], [2, 2, 0]], metres), rtol=1e-12)
    assert scene.taken == f"{metres:g} m per unit"
    assert loaded(package(PART, '<item objectid="1"/>', unit), "3mf", unit=1).bounds[1, 0] == 2


def test_items_and_components_with_their_transforms():
    whole = (
        '<object id="2"><components><component objectid="1" transform="1 0 0 0 1 0 0 0 1 10 0 0"/>'
        '<component objectid="1" transform="0 1 0 -1 0 0 0 0 1 0 20 0"/></components></object>' + PART
    )
    items = '<item objectid="2" transform="2 0 0 0 2 0 0 0 2 0 0 5"/><item objectid="1"/>'
    scene = loaded(package(whole, items, "meter"), "3mf")
    assert (scene.mesh_count, scene.instance_count) == (1, 3)
    # Rows act on row vectors: the second component turns x to y and y to -x, then moves up.
    np.testing.assert_allclose(corners(scene)[1], [[0, 40, 5], [0, 44, 5], [-4, 40, 5]])
    np.testing.assert_allclose(corners(scene)[0], [[20, 0, 5], [24, 0, 5], [20, 4, 5]])


def test_items_that_are_not_to_be_printed_and_other_models():
    scene, said = warned(package(PART, '<item objectid="1"/><item objectid="1" printable="0"/>'), "3mf")
    assert scene.instance_count == 1
    assert "1 item not to be printed" in said
    whole = '<object id="9"><components><component p:path="/3D/Objects/part.model" objectid="1"/></components></object>'
    other = {"3D/Objects/part.model": model(PART, "")}
    assert loaded(package(whole, '<item objectid="9"/>', **other), "3mf").triangle_count == 1


def test_extensions_of_3mf():
    item = '<item objectid="1"/>'
    beams = PART.replace("</mesh>", '<b:beamlattice xmlns:b="http://x/beamlattice/2017/02"/></mesh>')
    assert "beamlattice of object 1" in warned(package(beams, item), "3mf")[1]
    both = PART + '<object id="2"><b:booleanshape xmlns:b="http://x/booleanoperations/2023/07" objectid="1"/></object>'
    assert "booleanshape of object 2" in warned(package(both, item + '<item objectid="2"/>'), "3mf")[1]
    required = 'meter" xmlns:z="http://x/secret" requiredextensions="p'
    assert loaded(package(PART, item, required), "3mf").triangle_count
    with pytest.raises(LoadError, match="http://x/secret"):
        loaded(package(PART, item, required + " z"), "3mf")
    with pytest.raises(LoadError, match="'1' twice"):
        loaded(package(PART + PART, item), "3mf")


@pytest.mark.parametrize(
    ("data", "match"),
    [
        (package(PART, '<item objectid="7"/>'), "expected the object '7'"),
        (package(PART, '<item objectid="1"/>', "parsec"), "expected the unit"),
        (package(PART.replace('v3="2"', 'v3="3"'), '<item objectid="1"/>'), "from 0 to 2 in object 1, got 3"),
        (package(PART.replace('v3="2"', ""), '<item objectid="1"/>'), "v1, v2, v3 as numbers"),
        (package(PART.replace('x="2"', 'x="two"'), '<item objectid="1"/>'), "x, y, z as numbers"),
        (package(PART, '<item objectid="1" transform="1 0"/>'), "12 numbers"),
        (
            package(
                '<object id="1"><components><component objectid="1"/></components></object>', '<item objectid="1"/>'
            ),
            "circle",
        ),
        (zipped({"a.txt": "hello"}), "with a 3D model, found none"),
        (b"PK nothing", "readable archive"),
        (package(PART, '<item objectid="1"/>')[:-30], "readable archive"),
        (zipped({"3D/3dmodel.model": '<!DOCTYPE a [<!ENTITY a "b">]>' + model(PART, "")}), "document type"),
    ],
)
def test_3mf_that_is_refused(data, match):
    with pytest.raises(LoadError, match=match):
        loaded(data, "3mf")


def test_elements_beyond_the_limit_are_refused_before_they_are_read():
    assert loaded(dae(), "dae", limits=Limits(objects=30)).triangle_count == 6
    with pytest.raises(LoadError, match=r"elements of XML, got 1,0.*Limits\(objects=...\)"):
        loaded(dae(more="<extra/>" * 1000), "dae", limits=Limits(objects=30))
    item = '<item objectid="1"/>'
    many = PART.replace("<triangles>", "<triangles>" + '<triangle v1="0" v2="1" v3="2"/>' * 100)
    assert loaded(package(many, item), "3mf", limits=Limits(objects=30)).triangle_count == 101
