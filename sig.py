import subprocess,os,signal,time,json,sys,random
T='/work/main/target/release/timegap'
def kids(pid):
    out={}
    for p in os.listdir('/proc'):
        if p.isdigit():
            try:
                st=open(f'/proc/{p}/status').read()
                if f'PPid:\t{pid}\n' in st:
                    out[open(f'/proc/{p}/cmdline','rb').read().split(b'\0')[0].decode()]=int(p)
            except Exception: pass
    return out
svcs=sys.argv[1].split(','); sigs=sys.argv[2].split(',')
extra=sys.argv[3:]
for s in svcs:
    for g in sigs:
        out=f'/tmp/o1/{s}-{g}'
        p=subprocess.Popen([T,'run','following','--mode','realtime','--duration','6','--out',out,'--force',*extra],stdout=subprocess.PIPE,stderr=subprocess.STDOUT,stdin=subprocess.DEVNULL,text=True)
        time.sleep(2.5)
        k=kids(p.pid); 
        t=[v for n,v in k.items() if n=='timegap-'+s] if s!='launcher' else [p.pid]
        if not t: print(s,g,'no process',k); 
        for x in t: os.kill(x,getattr(signal,'SIG'+g))
        if g=='STOP':
            time.sleep(1.5)
            for x in t:
                try: os.kill(x,signal.SIGCONT)
                except ProcessLookupError: pass
        t0=time.time()
        try: o,_=p.communicate(timeout=30)
        except subprocess.TimeoutExpired: o='HANG'; p.kill()
        left=[f for f in os.listdir('/dev/shm')]
        print('=====',s,g,'status',p.returncode,'after',round(time.time()-t0,1),'shm',left)
        if g in('KILL','STOP') or s=='launcher' or '-v' in os.environ.get('V',''): print(o)
        else: print('\n'.join(l for l in o.split('\n') if any(w in l.lower() for w in('fault','died','restart','ended','result','complet','abort','level','missed','killed','signal'))))
