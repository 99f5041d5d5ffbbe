# Two blocks as in tests/cases/paper.toml, MSH 2.2 binary: python3 big.py 1264 632 big.msh
import sys, struct, array
nx, ny, out = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
names = ["lower.bottom","lower.right","lower.top","lower.left","upper.bottom","upper.right","upper.top","upper.left"]
n1 = (nx+1)*(ny+1)
with open(out,"wb") as f:
    f.write(b"$MeshFormat\n2.2 1 8\n"+struct.pack("<i",1)+b"\n$EndMeshFormat\n")
    f.write(b"$PhysicalNames\n10\n"+"".join(f'1 {i+1} "{n}"\n' for i,n in enumerate(names)).encode()+b'2 9 "lower"\n2 10 "upper"\n$EndPhysicalNames\n')
    f.write(f"$Nodes\n{2*n1}\n".encode())
    pack = struct.Struct("<iddd").pack
    k = 1
    for y0 in (0.0,1.0):
        for j in range(ny+1):
            y = y0 + 1.0 if j==ny else y0 + j/ny
            row = bytearray()
            for i in range(nx+1):
                row += pack(k, 2.0 if i==nx else 2.0*i/nx, y, 0.0); k += 1
            f.write(row)
    f.write(b"\n$EndNodes\n$Elements\n"+f"{2*(2*nx*ny+2*nx+2*ny)}\n".encode())
    e = 1
    for b in range(2):
        node = lambda i,j: b*n1 + j*(nx+1)+i+1
        sides = [[(node(i,0),node(i+1,0)) for i in range(nx)],[(node(nx,j),node(nx,j+1)) for j in range(ny)],
                 [(node(i,ny),node(i+1,ny)) for i in range(nx)],[(node(0,j),node(0,j+1)) for j in range(ny)]]
        for s,edges in enumerate(sides):
            tag = 4*b+s+1
            a = array.array("i",[1,len(edges),2])
            for p,q in edges: a.extend((e,tag,tag,p,q)); e += 1
            f.write(a.tobytes())
        f.write(array.array("i",[2,2*nx*ny,2]).tobytes())
        for j in range(ny):
            a = array.array("i")
            for i in range(nx):
                p=node(i,j); q=p+1; r=p+nx+2; s=p+nx+1
                a.extend((e,9+b,9+b,p,q,r,e+1,9+b,9+b,p,r,s)); e += 2
            f.write(a.tobytes())
    f.write(b"\n$EndElements\n")
