// Writes walker.fbx, walker.dae and walker.png: one figure in two formats, both in centimetres with Z up.
// Usage: node make_walker.mjs FOLDER. tests/scene/assimp_test.cpp has the same figure as glTF, in metres with Y up.
//
// A card of 0.4 x 1.8 m that two joints bend at 0.9 m (the middle row follows both), textured, and a hat: a triangle
// below the upper joint, on a mirrored node. The upper joint is turned by 30 degrees before its own rotation (FBX's
// PreRotation). Take "Walk" (1 s) moves 0.8 m forward and swings the upper joint; take "Nod" (0.5 s, in the FBX file only) tilts it.
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { deflateSync } from 'node:zlib';

const folder = process.argv[2];
const up = ([x, y, z]) => [100 * x, -100 * z, 100 * y].map((v) => v + 0); // metres, Y up -> centimetres, Z up
const points = [[-0.2, 0, 0], [0.2, 0, 0], [-0.2, 0.9, 0], [0.2, 0.9, 0], [-0.2, 1.8, 0], [0.2, 1.8, 0]];
const quads = [[0, 1, 3, 2], [2, 3, 5, 4]];
const uvs = points.map(([x, y]) => [(x + 0.2) / 0.4, y / 1.8]);
const hat = [[0, 0, 0], [0.2, 0, 0], [0.1, 0.2, 0]];
const weights = { hips: [[0, 1], [1, 1], [2, 0.5], [3, 0.5]], chest: [[2, 0.5], [3, 0.5], [4, 1], [5, 1]] };
const walk = { times: [0, 0.25, 0.5, 0.75, 1], swing: [0, 20, 0, -20, 0],
  hips: [[0, 0, 0], [0, 0.05, 0.2], [0, 0, 0.4], [0, 0.05, 0.6], [0, 0, 0.8]].map(up) };
const nod = { times: [0, 0.5], tilt: [0, -40] };
const c = Math.cos(Math.PI / 6), s = Math.sin(Math.PI / 6);
// Row-major: where the upper joint lies, and its inverse.
const chest = [1, 0, 0, 0, 0, c, -s, 0, 0, s, c, 90, 0, 0, 0, 1];
const chestInverse = [1, 0, 0, 0, 0, c, s, -90 * s, 0, -s, c, -90 * c, 0, 0, 0, 1];
const identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
const columns = (m) => m.map((_, i) => m[(i % 4) * 4 + Math.floor(i / 4)]);
const list = (values) => values.map((v) => String(+v.toFixed(9))).join(',');
const words = (values) => values.map((v) => String(+v.toFixed(9))).join(' ');

// ---- FBX --------------------------------------------------------------------------------------------------------------

const array = (name, values) => `${name}: *${values.length} {\n a: ${list(values)}\n}\n`;
const layer = (kind, index, mapping, body) => `${kind}: ${index} {\nVersion: 101\nName: ""\n` +
  `MappingInformationType: "${mapping}"\nReferenceInformationType: "Direct"\n${body}}\n`;
const property = (name, type, ...values) => `P: "${name}", "${type}", "", "A",${values.join(',')}\n`;

function fbxGeometry(id, name, vertices, faces, uv) {
  const corners = faces.flat();
  const ends = faces.flatMap((f) => f.map((v, i) => (i === f.length - 1 ? -v - 1 : v)));
  const layers = ['Normal', 'Material', ...(uv ? ['UV'] : [])];
  return `Geometry: ${id}, "Geometry::${name}", "Mesh" {\n` + array('Vertices', vertices.map(up).flat()) +
    array('PolygonVertexIndex', ends) + 'GeometryVersion: 124\n' +
    layer('LayerElementNormal', 0, 'ByPolygonVertex', array('Normals', corners.flatMap(() => [0, -1, 0]))) +
    (uv ? layer('LayerElementUV', 0, 'ByPolygonVertex', array('UV', corners.flatMap((v) => uv[v]))) : '') +
    'LayerElementMaterial: 0 {\nVersion: 101\nName: ""\nMappingInformationType: "AllSame"\n' +
    'ReferenceInformationType: "IndexToDirect"\nMaterials: *1 {\n a: 0\n}\n}\n' +
    `Layer: 0 {\nVersion: 100\n${layers.map((l) => `LayerElement:  {\nType: "LayerElement${l}"\nTypedIndex: 0\n}\n`).join('')}}\n}\n`;
}

const model = (id, name, kind, properties) =>
  `Model: ${id}, "Model::${name}", "${kind}" {\nVersion: 232\nProperties70:  {\n${properties}}\nShading: Y\n}\n`;
const cluster = (id, name, link, inverse) => `Deformer: ${id}, "SubDeformer::${name}", "Cluster" {\nVersion: 100\n` +
  array('Indexes', weights[name].map((w) => w[0])) + array('Weights', weights[name].map((w) => w[1])) +
  array('Transform', columns(inverse)) + array('TransformLink', columns(link)) + '}\n';

const kTick = 46186158000; // a second
function fbxTake(first, name, seconds, curves) {
  let objects = `AnimationStack: ${first}, "AnimStack::${name}", "" {\nProperties70:  {\n` +
    `P: "LocalStop", "KTime", "Time", "",${seconds * kTick}\nP: "ReferenceStop", "KTime", "Time", "",${seconds * kTick}\n}\n}\n` +
    `AnimationLayer: ${first + 1}, "AnimLayer::${name}", "" {\n}\n`;
  let connections = `C: "OO",${first + 1},${first}\n`;
  let id = first + 2;
  for (const { target, property: of, times, values } of curves) {
    const node = id++;
    const start = values.map((v) => v[0]);
    objects += `AnimationCurveNode: ${node}, "AnimCurveNode::${of === 'Lcl Rotation' ? 'R' : 'T'}", "" {\nProperties70:  {\n` +
      ['X', 'Y', 'Z'].map((axis, i) => `P: "d|${axis}", "Number", "", "A",${start[i]}\n`).join('') + '}\n}\n';
    connections += `C: "OO",${node},${first + 1}\nC: "OP",${node},${target}, "${of}"\n`;
    for (const [i, axis] of ['X', 'Y', 'Z'].entries()) {
      objects += `AnimationCurve: ${id}, "AnimCurve::", "" {\nDefault: ${start[i]}\nKeyVer: 4008\n` +
        array('KeyTime', times.map((t) => t * kTick)) + array('KeyValueFloat', values[i]) +
        array('KeyAttrFlags', [4]) + array('KeyAttrDataFloat', [0, 0, 0, 0]) + array('KeyAttrRefCount', [times.length]) + '}\n';
      connections += `C: "OP",${id++},${node}, "d|${axis}"\n`;
    }
  }
  return { objects, connections };
}

function fbx() {
  const zero = (times) => times.map(() => 0);
  const takes = [
    fbxTake(1000, 'Walk', 1, [
      { target: 11, property: 'Lcl Translation', times: walk.times, values: [0, 1, 2].map((i) => walk.hips.map((p) => p[i])) },
      { target: 12, property: 'Lcl Rotation', times: walk.times, values: [walk.swing, zero(walk.times), zero(walk.times)] }]),
    fbxTake(2000, 'Nod', 0.5, [
      { target: 12, property: 'Lcl Rotation', times: nod.times, values: [zero(nod.times), nod.tilt, zero(nod.times)] }])];
  return `; FBX 7.4.0 project file
FBXHeaderExtension:  {
FBXHeaderVersion: 1003
FBXVersion: 7400
Creator: "make_walker.mjs"
}
GlobalSettings:  {
Version: 1000
Properties70:  {
${[['UpAxis', 2], ['UpAxisSign', 1], ['FrontAxis', 1], ['FrontAxisSign', -1], ['CoordAxis', 0], ['CoordAxisSign', 1]]
    .map(([name, value]) => `P: "${name}", "int", "Integer", "",${value}\n`).join('')}P: "UnitScaleFactor", "double", "Number", "",1
P: "TimeMode", "enum", "", "",11
}
}
Objects:  {
${fbxGeometry(1, 'body', points, quads, uvs)}${fbxGeometry(2, 'hat', hat, [[0, 1, 2]])}` +
    model(10, 'body', 'Mesh', '') +
    model(11, 'hips', 'LimbNode', property('Lcl Translation', 'Lcl Translation', 0, 0, 0)) +
    model(12, 'chest', 'LimbNode', property('Lcl Translation', 'Lcl Translation', 0, 0, 90) +
      property('RotationActive', 'bool', 1) + property('PreRotation', 'Vector3D', 30, 0, 0)) +
    model(13, 'hat', 'Mesh', property('Lcl Translation', 'Lcl Translation', ...up([0, 0.9, 0.1])) +
      property('Lcl Scaling', 'Lcl Scaling', -1, 1, 1)) +
    `NodeAttribute: 21, "NodeAttribute::hips", "LimbNode" {\nTypeFlags: "Skeleton"\n}
NodeAttribute: 22, "NodeAttribute::chest", "LimbNode" {\nTypeFlags: "Skeleton"\n}
NodeAttribute: 23, "NodeAttribute::lamp", "Light" {\n}
Model: 14, "Model::lamp", "Light" {\nVersion: 232\n}
Material: 30, "Material::cloth", "" {\nVersion: 102\nShadingModel: "lambert"\nProperties70:  {
${property('DiffuseColor', 'Color', 0.8, 0.8, 0.8)}}\n}
Material: 31, "Material::felt", "" {\nVersion: 102\nShadingModel: "lambert"\nProperties70:  {
${property('DiffuseColor', 'Color', 0.5, 0.25, 0.125)}}\n}
Texture: 40, "Texture::cloth", "" {\nType: "TextureVideoClip"\nVersion: 202\nTextureName: "Texture::cloth"
FileName: "C:\\art\\walker.png"\nRelativeFilename: "..\\art\\walker.png"\n}
Deformer: 50, "Deformer::skin", "Skin" {\nVersion: 101\nLink_DeformAcuracy: 50\n}
` + cluster(51, 'hips', identity, identity) + cluster(52, 'chest', chest, chestInverse) + takes.map((t) => t.objects).join('') + `}
Connections:  {
C: "OO",10,0\nC: "OO",11,0\nC: "OO",12,11\nC: "OO",13,12\nC: "OO",14,0\nC: "OO",1,10\nC: "OO",2,13
C: "OO",21,11\nC: "OO",22,12\nC: "OO",23,14\nC: "OO",30,10\nC: "OO",31,13\nC: "OP",40,30, "DiffuseColor"
C: "OO",50,1\nC: "OO",51,50\nC: "OO",52,50\nC: "OO",11,51\nC: "OO",12,52
${takes.map((t) => t.connections).join('')}}
`;
}

// ---- COLLADA ----------------------------------------------------------------------------------------------------------

const source = (id, values, stride, names, type = 'float') => `<source id="${id}"><${type === 'name' ? 'Name' : 'float'}_array ` +
  `id="${id}-array" count="${values.length}">${type === 'name' ? values.join(' ') : words(values)}` +
  `</${type === 'name' ? 'Name' : 'float'}_array><technique_common><accessor source="#${id}-array" ` +
  `count="${values.length / stride}" stride="${stride}">${names.map((n) => `<param name="${n}" type="${stride === 16 ? 'float4x4' : type}"/>`).join('')}` +
  '</accessor></technique_common></source>\n';

function daeGeometry(id, vertices, faces, material, uv) {
  const corners = faces.flat();
  return `<geometry id="${id}" name="${id}"><mesh>\n` + source(`${id}-p`, vertices.map(up).flat(), 3, ['X', 'Y', 'Z']) +
    source(`${id}-n`, [0, -1, 0], 3, ['X', 'Y', 'Z']) + (uv ? source(`${id}-t`, uv.flat(), 2, ['S', 'T']) : '') +
    `<vertices id="${id}-v"><input semantic="POSITION" source="#${id}-p"/></vertices>\n` +
    `<polylist material="${material}" count="${faces.length}"><input semantic="VERTEX" source="#${id}-v" offset="0"/>` +
    `<input semantic="NORMAL" source="#${id}-n" offset="1"/>` +
    (uv ? `<input semantic="TEXCOORD" source="#${id}-t" offset="2" set="0"/>` : '') +
    `<vcount>${words(faces.map((f) => f.length))}</vcount><p>${corners.map((v) => (uv ? `${v} 0 ${v}` : `${v} 0`)).join(' ')}</p>` +
    '</polylist></mesh></geometry>\n';
}

const daeAnimation = (id, target, times, values) => `<animation id="${id}">\n` + source(`${id}-i`, times, 1, ['TIME']) +
  source(`${id}-o`, values.flat(), Array.isArray(values[0]) ? 3 : 1, Array.isArray(values[0]) ? ['X', 'Y', 'Z'] : ['ANGLE']) +
  source(`${id}-l`, times.map(() => 'LINEAR'), 1, ['INTERPOLATION'], 'name') +
  `<sampler id="${id}-s"><input semantic="INPUT" source="#${id}-i"/><input semantic="OUTPUT" source="#${id}-o"/>` +
  `<input semantic="INTERPOLATION" source="#${id}-l"/></sampler><channel source="#${id}-s" target="${target}"/></animation>\n`;
const daeMaterial = (name, diffuse, more = '') => `<effect id="${name}-fx"><profile_COMMON>${more}` +
  `<technique sid="common"><lambert><diffuse>${diffuse}</diffuse></lambert></technique></profile_COMMON></effect>\n`;
const bind = (name, of) => `<bind_material><technique_common><instance_material symbol="${name}" target="#${name}">` +
  `${of}</instance_material></technique_common></bind_material>`;

function dae() {
  const pairs = points.map((_, v) => ['hips', 'chest'].flatMap((j, k) => weights[j].filter((w) => w[0] === v).map((w) => [k, w[1] === 1 ? 0 : 1])));
  return `<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="centimeter" meter="0.01"/><up_axis>Z_UP</up_axis></asset>
<library_images><image id="walker-png"><init_from>file:///C:/art/walker.png</init_from></image></library_images>
<library_effects>
${daeMaterial('cloth', '<texture texture="cloth-sampler" texcoord="UVMap"/>',
    '<newparam sid="cloth-surface"><surface type="2D"><init_from>walker-png</init_from></surface></newparam>' +
    '<newparam sid="cloth-sampler"><sampler2D><source>cloth-surface</source></sampler2D></newparam>')}${
    daeMaterial('felt', '<color>0.5 0.25 0.125 1</color>')}</library_effects>
<library_materials><material id="cloth" name="cloth"><instance_effect url="#cloth-fx"/></material>
<material id="felt" name="felt"><instance_effect url="#felt-fx"/></material></library_materials>
<library_geometries>
${daeGeometry('body', points, quads, 'cloth', uvs)}${daeGeometry('hat-shape', hat, [[0, 1, 2]], 'felt')}</library_geometries>
<library_controllers><controller id="body-skin"><skin source="#body">
<bind_shape_matrix>${words(identity)}</bind_shape_matrix>
${source('skin-j', ['hips', 'chest'], 1, ['JOINT'], 'name')}${source('skin-b', [...identity, ...chestInverse], 16, ['TRANSFORM'])}${
    source('skin-w', [1, 0.5], 1, ['WEIGHT'])}<joints><input semantic="JOINT" source="#skin-j"/><input semantic="INV_BIND_MATRIX" source="#skin-b"/></joints>
<vertex_weights count="6"><input semantic="JOINT" source="#skin-j" offset="0"/><input semantic="WEIGHT" source="#skin-w" offset="1"/>
<vcount>${words(pairs.map((p) => p.length))}</vcount><v>${words(pairs.flat(2))}</v></vertex_weights>
</skin></controller></library_controllers>
<library_animations><animation id="Walk" name="Walk">
${daeAnimation('walk-hips', 'hips/place', walk.times, walk.hips)}${daeAnimation('walk-chest', 'chest/swing.ANGLE', walk.times, walk.swing)}</animation></library_animations>
<library_visual_scenes><visual_scene id="scene" name="scene">
<node id="hips" name="hips" sid="hips" type="JOINT"><translate sid="place">0 0 0</translate>
<node id="chest" name="chest" sid="chest" type="JOINT"><translate sid="offset">0 0 90</translate><rotate sid="before">1 0 0 30</rotate>
<rotate sid="swing">1 0 0 0</rotate>
<node id="hat" name="hat"><translate>${words(up([0, 0.9, 0.1]))}</translate><scale>-1 1 1</scale>
<instance_geometry url="#hat-shape">${bind('felt', '')}</instance_geometry></node></node></node>
<node id="figure" name="figure"><instance_controller url="#body-skin"><skeleton>#hips</skeleton>${
    bind('cloth', '<bind_vertex_input semantic="UVMap" input_semantic="TEXCOORD" input_set="0"/>')}</instance_controller></node>
</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>
`;
}

// ---- PNG --------------------------------------------------------------------------------------------------------------

// 2 x 2, the rows filtered by nothing: red and green above blue and white.
function crc32(bytes) {
  let crc = ~0;
  for (const byte of bytes) {
    crc ^= byte;
    for (let i = 0; i < 8; ++i) crc = (crc >>> 1) ^ (crc & 1 ? 0xEDB88320 : 0);
  }
  return ~crc >>> 0;
}

function png() {
  const chunk = (type, data) => {
    const out = Buffer.alloc(12 + data.length);
    out.writeUInt32BE(data.length, 0);
    out.write(type, 4, 'latin1');
    data.copy(out, 8);
    out.writeUInt32BE(crc32(out.subarray(4, 8 + data.length)), 8 + data.length);
    return out;
  };
  const header = Buffer.from([0, 0, 0, 2, 0, 0, 0, 2, 8, 2, 0, 0, 0]);
  const rows = Buffer.from([0, 255, 0, 0, 0, 255, 0, 0, 0, 0, 255, 255, 255, 255]);
  return Buffer.concat([Buffer.from('\x89PNG\r\n\x1A\n', 'latin1'), chunk('IHDR', header),
    chunk('IDAT', deflateSync(rows)), chunk('IEND', Buffer.alloc(0))]);
}

writeFileSync(join(folder, 'walker.fbx'), fbx());
writeFileSync(join(folder, 'walker.dae'), dae());
writeFileSync(join(folder, 'walker.png'), png());
